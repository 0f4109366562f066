//! Draws supplement Figure 6: silhouettes of a coarsely tessellated relief, where the filtered normal faces away from the
//! viewer.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec3Swizzles as _};

use crate::report::page::Page;
use crate::report::studio::Studio;
use crate::report::subject::Subject;
use crate::report::verdict::Shot;
use leadr_maps::{RgbImage, procedural};
use leadr_reflectance::color::luminance;
use leadr_reflectance::facets::projected_area::meso_area;
use leadr_reflectance::frame::{frame_about, to_frame};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::{facet_area, grid_lambda, grid_node, slope_sample};
use leadr_render::camera::Camera;
use leadr_render::frame::Layer;
use leadr_render::scene::Object;
use leadr_render::settings::{PixelKernel, Quadrature, RenderSettings, ShadingOptions, Technique};
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::tessellation::TessellationSettings;
use leadr_scenes::sphere::displaced_sphere;
use leadr_scenes::stage::{SPHERE_REPEAT, Stage, sphere_views};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table};

/// The number of slopes per side of the paper's grid.
const GRID: u32 = 5;
/// The Beckmann roughness of the base, which is low, so that the grid extends only slightly beyond the relief's own slopes.
const ROUGHNESS: f32 = 0.1;
/// The number of patches along a cube edge, which is low, so that triangles can be large.
const PATCHES: u32 = 4;
/// The standard deviation of the slopes.
const SLOPE: f32 = 0.4;
/// The width of the bumps, as a fraction of the map's repeat.
const FEATURE: f32 = 0.025;
/// A pixel counts as black below this fraction of the object's mean luminance.
const BLACK: f64 = 1e-3;

/// Whether the paper's equations fail at a pixel, because normals or slopes face away.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Backfacing {
    /// The mesonormal faces the viewer, or no object covers the pixel.
    No,
    /// The mesonormal faces away from the viewer, so the projected area is negative.
    Away,
    /// All slopes of the grid also face away from the viewer, so their weights sum to zero.
    Wholly,
}

/// Returns the state of each pixel in the renderer's last picture.
fn backfacing(
    subject: &mut Subject,
    camera: &Camera,
    size: (u32, u32),
    shot: &Shot,
) -> Result<Vec<Backfacing>, LabError> {
    let mut layer = |which: Layer| subject.renderer.layer(which);
    let (normals, means) = (layer(Layer::Normal)?, layer(Layer::MeanSlope)?);
    let (covariances, roughness) = (layer(Layer::Covariance)?, layer(Layer::Roughness)?);
    let rays = camera.rays(size, Vec2::ZERO);
    let lambda = grid_lambda(GRID);
    let of = |i: usize| {
        let normal = Vec3::from_slice(&normals[i]).as_dvec3();
        if shot.coverage[i] <= 0.0 || normal.length_squared() < 0.5 {
            return Backfacing::No;
        }
        let at = |k: u32, of: u32| (2.0 * k as f32 + 1.0) / of as f32 - 1.0;
        let (x, y) = (at(i as u32 % size.0, size.0), at(i as u32 / size.0, size.1));
        let ray = rays[2] + x * rays[0] + y * rays[1];
        let wo = to_frame(&frame_about(normal.normalize()), -ray.as_dvec3().normalize());
        let m = DVec2::new(means[i][0].into(), means[i][1].into());
        if meso_area(wo, m) >= 0.0 {
            return Backfacing::No;
        }
        let base = 0.5 * f64::from(roughness[i][0]).powi(2);
        let s = Vec3::from_slice(&covariances[i]).as_dvec3() + DVec3::new(base, base, 0.0);
        let seen = |k: u32| facet_area(wo, slope_sample(grid_node(k / GRID, k % GRID, GRID, lambda).xy(), m, s)) > 0.0;
        if (0..GRID * GRID).any(seen) { Backfacing::Away } else { Backfacing::Wholly }
    };
    Ok((0..shot.coverage.len()).map(of).collect())
}

fn black(shot: &Shot) -> usize {
    let covered = || (0..shot.coverage.len()).filter(|&i| shot.coverage[i] > 0.5);
    let value = |i: usize| luminance(Vec3::from(shot.image.texels[i]).as_dvec3());
    let mean = covered().map(value).sum::<f64>() / covered().count().max(1) as f64;
    covered().filter(|&i| value(i) <= BLACK * mean).count()
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Supplement Figure 6",
        "A Gaussian relief on a sphere under the sky, tessellated more and more coarsely. Left: pixels without a value in the paper. Red \
        ones have a filtered normal that faces away from the viewer (a negative projected area); in black ones all slopes of the 5×5 grid \
        also face away (0/0). Middle: the same grid here without the kernel; the mean slope is tilted until a node of the grid is \
        visible. Right: the default; the mean slope is tilted back to edge-on and the difference counts as roughness (tilt_to_edge, part \
        of --pixel-kernel).",
    );
    let side = studio.pick(96, 256);
    let size = (side, side);
    let map = procedural::gaussian(512, 512, 3, SLOPE, FEATURE);
    let tile = studio.pick(32, 64);
    let (mesh, heights) =
        displaced_sphere(&HeightField::repeating(map), SPHERE_REPEAT, PATCHES, tile, [0.3, 0.25, 0.2, ROUGHNESS]);
    let object = Object::new("sphere", mesh).with_heights(heights, SPHERE_REPEAT);
    let stage = Stage::still(vec![object], sphere_views());
    let mut subject = Subject::under_the_sky(studio, stage, 0.0)?;
    let camera = subject.stage.views.mid;
    let state = subject.seen_by(&camera);
    let mut table = Table::new(
        format!("{side} × {side} pixels, one sample; pixels of the sphere"),
        [
            "pixels per triangle",
            "without a value in the paper",
            "grid, without the kernel",
            "default",
            "pixels",
            "facing away",
            "0/0",
            "black pixels, middle",
            "black pixels, right",
        ],
    );
    let (mut most, mut left) = ((0, 0), 0);
    for pixels_per_triangle in [4.0, 40.0, 400.0] {
        let options = ShadingOptions::default();
        let paper = ShadingOptions {
            quadrature: Quadrature::Grid(GRID),
            pixel_kernel: PixelKernel::Off,
            shadowing: Shadowing::Smith,
            ..options
        };
        let shoot = |options: ShadingOptions, subject: &mut Subject| {
            let settings = RenderSettings {
                size,
                shading: Technique::Leadr.with(options),
                tessellation: TessellationSettings { pixels_per_triangle, ..Default::default() },
                ..Default::default()
            };
            // The call fails if a pixel is not finite.
            studio.shoot(&mut subject.renderer, &state, &settings)
        };
        let shown = shoot(options, &mut subject)?;
        let grid = shoot(paper, &mut subject)?;
        let backfacing = backfacing(&mut subject, &camera, size, &grid)?;
        let count = |which: &[Backfacing]| backfacing.iter().filter(|backfacing| which.contains(backfacing)).count();
        let (away, wholly) = (count(&[Backfacing::Away, Backfacing::Wholly]), count(&[Backfacing::Wholly]));
        let paint = |(backfacing, texel): (&Backfacing, &[f32; 3])| match backfacing {
            Backfacing::No => *texel,
            Backfacing::Away => [1.0, 0.0, 0.0],
            Backfacing::Wholly => [0.0; 3],
        };
        let painted = backfacing.iter().zip(&grid.image.texels).map(paint).collect();
        let painted = RgbImage { width: side, height: side, texels: painted };
        let name = |what: &str| format!("figures-silhouettes-{pixels_per_triangle}-{what}");
        let pictures = [
            studio.picture(&name("paper"), &painted, 1.0, "pixels without a value in the paper", Vec::new())?,
            studio.picture(&name("grid"), &grid.image, 1.0, "grid, without the kernel", Vec::new())?,
            studio.picture(&name("default"), &shown.image, 1.0, "default", Vec::new())?,
        ];
        let (pixels, dark, remain) = (shown.coverage.iter().filter(|&&c| c > 0.5).count(), black(&grid), black(&shown));
        let numbers = [pixels, away, wholly, dark, remain].map(|count| Cell::from(count as f64));
        let head = std::iter::once(Cell::from(format!("{pixels_per_triangle}")));
        table.row(head.chain(pictures.map(Cell::Figure)).chain(numbers));
        page.check(format!("pixels facing away, {pixels_per_triangle} pixels per triangle"), away as f64);
        page.check(format!("pixels of 0/0, {pixels_per_triangle} pixels per triangle"), wholly as f64);
        page.check(format!("black pixels by default, {pixels_per_triangle} pixels per triangle"), remain as f64);
        most = (most.0.max(away), most.1.max(wholly));
        left += dark + remain;
    }
    page.html.table(&table);
    page.find(&format!(
        "the filtered normal faces away in up to {} pixels, and all slopes of the 5×5 grid also do in up to {} of them; {left} drawn pixels are black, and none is NaN or infinite.",
        most.0, most.1
    ));
    Ok(())
}
