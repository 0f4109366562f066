//! Draws figures 3, 8, 9, 13, 14 and 17 with the project's own bricks instead of the game's assets, and measures algorithm 5 on them.

use glam::{Affine3A, DVec3, Vec3};

use crate::relaxation::{relative_difference, relaxed_heights};
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use crate::report::verdict::Shot;
use leadr_maps::derive::{Difference, Integration, Occlusion, Slopes, VisibilityMap, heights_of_slopes, visibility};
use leadr_maps::material::{Encoding, NormalMap, Texture, TextureWrap, alpha_code, green_axis};
use leadr_maps::srgb::srgb8_from_linear;
use leadr_maps::{HeightMap, Rgb8Image, RgbImage, Wrap, load_color, load_height_channel, load_height_map, load_raster};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::Shortening;
use leadr_reflectance::masking::occlusion::ConeEdge;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::scene::{FrameState, MaterialMap, Object, Pose, PropertyMap, Sun};
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_render::surfaces::displacement::HeightField;
use leadr_scenes::plane::{even, plane};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Figure, Table, number};
use leadr_tools::metrics::compare::rrmse;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/bricks");
/// The height between black and white of the displacement map, in texture widths (`assets/README.md`).
const WHITE: f32 = 0.02;
/// The direction to the viewer, and the direction of its reflection.
const VIEW: Vec3 = Vec3::new(0.0, -0.5, 0.866);
const REFLECTED: Vec3 = Vec3::new(0.0, 0.5, 0.866);
/// A low sun.
const LOW: Vec3 = Vec3::new(0.9, 0.2, 0.2);
/// The radiance of the surroundings, equal in all directions.
const SURROUNDINGS: f32 = 0.3;
/// The distance of the camera in metres. A repeat of the maps is one metre wide.
const DISTANCE: f32 = 60.0;
/// The pixels of a near picture along a pixel of a far picture.
const BLOCK: u32 = 8;
/// The sweeps of each level of the relaxation.
const SWEEPS: [u32; 3] = [3, 10, 100];

/// The maps of the bricks. The rows run upwards, like the texture coordinates of the plane.
struct Bricks {
    side: u32,
    slopes: Slopes,
    /// The linear colour and the roughness `α`.
    colors: Vec<[f32; 4]>,
    /// The displacement map, in texture widths.
    displacement: HeightMap,
}

impl Bricks {
    /// Loads the maps and averages them to `side` texels, which divides their 768 texels.
    fn load(side: u32) -> Result<Self, LabError> {
        let path = |role: &str| format!("{FOLDER}/bricks_{role}.png");
        let raster = load_raster(path("NormalGL"))?;
        let from = raster.width();
        let green = green_axis(&raster);
        let normals = NormalMap { texture: Texture::new(raster, "normals", Encoding::Linear), green, scale: 1.0 };
        let slopes = Slopes::of_normal_map(&normals).map_err(fault)?;
        let color = load_color(path("Color"))?;
        let roughness = load_height_channel(path("Roughness"), 0)?;
        let displacement = load_height_map(path("Displacement"))?;
        let slopes = averaged(from, side, |i| {
            let [across, down] = slopes.texels()[i];
            [across, -down]
        });
        let colors = averaged(from, side, |i| {
            let [r, g, b] = color.texels[i];
            [r, g, b, roughness.texels[i].powi(2)]
        });
        let heights = averaged(from, side, |i| [WHITE * displacement.texels[i]]).into_flattened();
        Ok(Self {
            side,
            slopes: Slopes::new(side, side, slopes).map_err(fault)?,
            colors,
            displacement: HeightMap::new(side, side, heights).map_err(fault)?,
        })
    }

    fn heights(&self, smoothness: f64) -> Result<HeightMap, LabError> {
        let how = Integration { wrap: Wrap::Repeat, difference: Difference::Triangles, smoothness };
        Ok(heights_of_slopes(&self.slopes, &how, &|_| ()).map_err(fault)?.heights)
    }

    fn normal(&self, i: usize) -> DVec3 {
        let [across, up] = self.slopes.texels()[i];
        DVec3::new(-f64::from(across), -f64::from(up), 1.0).normalize()
    }

    /// Returns the plane with these maps. `colors` are linear colours and the roughness `α`.
    fn object(&self, colors: &[[f32; 4]], cones: Option<&VisibilityMap>) -> Object {
        let side = self.side;
        let code = |[r, g, b, alpha]: [f32; 4]| {
            let [r, g, b] = [r, g, b].map(srgb8_from_linear);
            [r, g, b, alpha_code(alpha)]
        };
        let cones = cones.map(|open| {
            let cone = |i: u32| {
                let [x, y, z] = open.at(i % side, i / side);
                // In cone maps, y points against t.
                [x, -y, z, open.visibility[i as usize]]
            };
            let texels = (0..side * side).map(cone).collect();
            PropertyMap { width: side, height: side, texels, wrap: [TextureWrap::Repeat; 2] }
        });
        let material =
            MaterialMap { cones, ..MaterialMap::new(side, side, colors.iter().copied().map(code).collect()) };
        let flat = HeightMap { width: side, height: side, texels: vec![0.0; colors.len()] };
        Object::new("bricks", plane(8.0, 16, 1.0, [1.0; 4], even))
            .with_heights(HeightField::repeating(flat), 1.0)
            .with_slopes(self.slopes.texels().to_vec())
            .with_material(material)
            .without_shadow()
    }
}

/// Averages a square map of `from` texels to `side` texels, and flips its rows.
fn averaged<const N: usize>(from: u32, side: u32, value: impl Fn(usize) -> [f32; N]) -> Vec<[f32; N]> {
    let block = from / side;
    let texel = |i: u32| {
        let mut sum = [0.0; N];
        for k in 0..block * block {
            let (x, y) = (i % side * block + k % block, i / side * block + k / block);
            let texel = value(((from - 1 - y) * from + x) as usize);
            sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += value / (block * block) as f32);
        }
        sum
    };
    (0..side * side).map(texel).collect()
}

/// Planes on the device, of which one is visible at a time.
struct Wall {
    renderer: Renderer,
    objects: usize,
}

impl Wall {
    fn new(studio: &Studio, objects: Vec<Object>) -> Result<Self, LabError> {
        let grey = RgbImage::new(8, 4, vec![[SURROUNDINGS; 3]; 32]).map_err(fault)?;
        let count = objects.len();
        let environment = Environment::from_equirect(&studio.gpu, 16, &grey)?;
        Ok(Self { renderer: Renderer::new(&studio.gpu, objects, environment)?, objects: count })
    }

    /// Draws plane `visible`, with `metres` of it across the picture.
    fn draw(
        &mut self,
        studio: &Studio,
        size: u32,
        metres: f32,
        (visible, technique, options): (usize, Technique, ShadingOptions),
        sun: Option<Vec3>,
    ) -> Result<Shot, LabError> {
        let degrees = 2.0 * (0.5 * metres / DISTANCE).atan().to_degrees();
        let camera = Camera::looking_at(VIEW * DISTANCE, Vec3::ZERO, degrees);
        // The other planes are far below.
        let pose = |k: usize| {
            let down = if k == visible { 0.0 } else { 1000.0 };
            Pose::Rigid(Affine3A::from_translation(Vec3::NEG_Z * down))
        };
        let sun = sun.map(|towards| Sun { direction: towards.normalize(), irradiance: Vec3::splat(2.0) });
        let state = FrameState { sun, ..FrameState::new(camera, (0..self.objects).map(pose).collect()) };
        let settings = RenderSettings {
            size: (size, size),
            samples: 4,
            displacement: false,
            shadows: false,
            shading: technique.with(ShadingOptions { shadowing: Shadowing::NormalMap, ..options }),
            ..Default::default()
        };
        studio.shoot(&mut self.renderer, &state, &settings)
    }
}

/// Returns a picture with the left half of `a` and the right half of `b`.
fn halves(a: &RgbImage, b: &RgbImage) -> Result<RgbImage, LabError> {
    let (width, height) = (a.width, a.height);
    let texel = |i: u32| if i % width < width / 2 { a.texels[i as usize] } else { b.texels[i as usize] };
    RgbImage::new(width, height, (0..width * height).map(texel).collect()).map_err(fault)
}

/// Stores a map whose rows run upwards. `value` returns codes from 0 to 1 by texel.
fn map_picture(
    studio: &mut Studio,
    name: &str,
    side: u32,
    caption: &str,
    value: impl Fn(usize) -> [f64; 3],
) -> Result<Figure, LabError> {
    let texel = |i: u32| {
        let row = side - 1 - i / side;
        value((row * side + i % side) as usize).map(|v| (255.0 * v.clamp(0.0, 1.0)).round() as u8)
    };
    let image = Rgb8Image::new(side, side, (0..side * side).map(texel).collect()).map_err(fault)?;
    studio.codes(name, &image, caption, vec![caption.to_owned()])
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    let bricks = Bricks::load(studio.pick(96, 256))?;
    filters(studio, page, &bricks)?;
    gloss_levels(studio, page, &bricks)?;
    heights(studio, page, &bricks)?;
    relaxation(studio, page)?;
    occlusion(studio, page, &bricks)
}

fn mean_of(shot: &Shot) -> f64 {
    shot.image.mean().iter().sum::<f64>() / 3.0
}

/// Draws figures 3 and 9.
fn filters(studio: &mut Studio, page: &mut Page, bricks: &Bricks) -> Result<(), LabError> {
    let mut wall = Wall::new(studio, vec![bricks.object(&bricks.colors, None)])?;
    let size = studio.pick(24, 96);
    // A pixel of the averaged pictures is one texel wide.
    let metres = (BLOCK * size) as f32 / bricks.side as f32;
    let mut shots = Vec::new();
    for technique in [Technique::NormalMip, Technique::Gloss] {
        let mut draw =
            |size| wall.draw(studio, size, metres, (0, technique, ShadingOptions::default()), Some(REFLECTED));
        let (far, near) = (draw(size)?, draw(BLOCK * size)?.of_blocks(BLOCK).map_err(fault)?);
        shots.push((technique.name(), far, near));
    }
    page.begin(
        "Chan Figure 3",
        "The bricks of assets/bricks against the sun, with eight texels across a pixel. Left half: mipmapped normals (normal-mip). Right half: \
        shortened normals (gloss).",
    );
    let image = halves(&shots[0].1.image, &shots[1].1.image)?;
    let caption = "normal-mip | gloss";
    page.html
        .figures(&[studio.picture("chan-bricks-split", &image, 0.5, caption, vec![caption.to_owned()])?.enlarged(3)]);
    let ratio = mean_of(&shots[0].1) / mean_of(&shots[1].1);
    page.check("mean of normal-mip over mean of gloss", ratio);
    page.begin(
        "Chan Figure 9",
        "The same wall drawn in the distance, and drawn with 8 × 8 times as many pixels, which are then averaged. A filter that keeps the \
        appearance makes both pictures equal, except for the blur of the maps' filter, which blocks of pixels do not show.",
    );
    let mut figures = Vec::new();
    for (name, far, near) in &shots {
        for (what, shot) in [("distant", far), ("averaged", near)] {
            let caption = format!("{name}, {what}");
            let file = format!("chan-bricks-{name}-{what}");
            figures.push(studio.picture(&file, &shot.image, 0.5, &caption, vec![caption.clone()])?.enlarged(3));
        }
        let error = rrmse(&near.image, &far.image).map_err(fault)?;
        let [far_blocks, near_blocks] =
            [far, near].map(|shot| shot.of_blocks(BLOCK).map(|shot| shot.image).map_err(fault));
        let error_of_blocks = rrmse(&near_blocks?, &far_blocks?).map_err(fault)?;
        page.check(format!("{name}: distant less averaged, rms relative to the mean"), error);
        page.check(format!("{name}: the same for blocks of 8 × 8 pixels"), error_of_blocks);
        page.check(format!("{name}: mean of distant over mean of averaged"), mean_of(far) / mean_of(near));
        page.find(&format!(
            "with {name}, the distant wall differs from the averaged near wall by {} rms per pixel, and by {} per block of 8 × 8 pixels.",
            number(error),
            number(error_of_blocks)
        ));
    }
    page.html.figures(&figures);
    Ok(())
}

/// Draws figure 8: levels of gloss from means of shortened normals (algorithms 2 and 3).
fn gloss_levels(studio: &mut Studio, page: &mut Page, bricks: &Bricks) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 8",
        "Levels 0 to 5 of the gloss of the bricks, from the lengths of the mean shortened normals, all enlarged to one size. Coarse levels \
        are darker, because they contain the variation of the normals.",
    );
    let shortening = Shortening::default();
    let shortened = |i: usize| shortening.length(bricks.colors[i][3].into()) * bricks.normal(i);
    let mut side = bricks.side;
    let mut normals: Vec<DVec3> = (0..bricks.colors.len()).map(shortened).collect();
    let (mut figures, mut means) = (Vec::new(), Vec::new());
    for level in 0..6 {
        let gloss: Vec<f64> =
            normals.iter().map(|n| Gloss::Wwii.gloss(shortening.alpha_of_length(n.length()))).collect();
        let mean = gloss.iter().sum::<f64>() / gloss.len() as f64;
        page.check(format!("mean gloss of level {level}"), mean);
        means.push(mean);
        let most = 0.5;
        let name = format!("chan-bricks-gloss-{level}");
        let figure = map_picture(studio, &name, side, &format!("level {level}"), |i| [gloss[i] / most; 3])?;
        figures.push(figure.enlarged(1 << level));
        let half = side / 2;
        let mean = |i: u32| {
            let corner = (i / half * 2 * side + i % half * 2) as usize;
            [0, 1, side as usize, side as usize + 1].iter().map(|k| normals[corner + k]).sum::<DVec3>() / 4.0
        };
        normals = (0..half * half).map(mean).collect();
        side = half;
    }
    page.html.figures(&figures);
    page.find(&format!("the mean gloss falls from {} to {} over six levels.", number(means[0]), number(means[5])));
    Ok(())
}

/// Draws figure 13: heights of normals, and occlusion of heights.
fn heights(studio: &mut Studio, page: &mut Page, bricks: &Bricks) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 13",
        "The normals of the bricks, the heights of the normals by the direct solution at smoothness 1, and the occlusion of these heights.",
    );
    let heights = bricks.heights(1.0)?;
    let open = visibility(&heights, 1.0, &Occlusion::default(), &|_| ()).map_err(fault)?;
    let ends = heights.texels.iter().fold((f32::MAX, f32::MIN), |(a, b), &h| (a.min(h), b.max(h)));
    let height = |i: usize| f64::from((heights.texels[i] - ends.0) / (ends.1 - ends.0).max(1e-9));
    let side = bricks.side;
    let scale = studio.pick(2, 1);
    let figures = [
        map_picture(studio, "chan-bricks-normals", side, "normals", |i| (0.5 * bricks.normal(i) + 0.5).to_array())?,
        map_picture(studio, "chan-bricks-heights", side, "heights", |i| [height(i); 3])?,
        map_picture(studio, "chan-bricks-occlusion", side, "occlusion", |i| [open.visibility[i].into(); 3])?,
    ];
    page.html.figures(&figures.map(|figure| figure.enlarged(scale)));
    let error = relative_difference(&heights, &bricks.displacement);
    let mean = open.visibility.iter().map(|&v| f64::from(v)).sum::<f64>() / open.visibility.len() as f64;
    page.check("heights less the displacement map, rms relative to its rms", error);
    page.check("mean visibility", mean);
    page.find(&format!("the heights of the normals differ from the displacement map by {} of its rms.", number(error)));
    Ok(())
}

/// Compares the relaxation of algorithm 5 with the direct solution.
fn relaxation(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Chan algorithm 5",
        "Heights of the bricks' normals by relaxation, coarse levels first, against the direct solution of the same equation \
        (smoothness 1): the root mean square difference relative to the heights. The last row is the direct solution at the default \
        smoothness of leadr bake, whose equation is a different one.",
    );
    let bricks = Bricks::load(studio.pick(96, 768))?;
    let direct = bricks.heights(1.0)?;
    let mut table = Table::new("Heights against the direct solution", ["", "relative difference"]);
    let mut errors = Vec::new();
    for sweeps in SWEEPS {
        let relaxed = relaxed_heights(&bricks.slopes, Difference::Triangles, sweeps).map_err(fault)?;
        let error = relative_difference(&relaxed, &direct);
        let name = format!("{sweeps} sweeps of each level");
        page.check(name.clone(), error);
        table.row([Cell::from(name), Cell::from(error)]);
        errors.push(number(error));
    }
    let smoothness = Integration::default().smoothness;
    let error = relative_difference(&bricks.heights(smoothness)?, &direct);
    let name = format!("direct, smoothness {smoothness}");
    page.check(name.clone(), error);
    table.row([Cell::from(name), Cell::from(error)]);
    page.html.table(&table);
    page.find(&format!(
        "3, 10 and 100 sweeps of each level leave {} of the heights. The default smoothness differs by {}.",
        errors.join(", "),
        number(error)
    ));
    Ok(())
}

/// Draws figures 14 and 17: the wall with and without occlusion cones, in shadow and in the sun.
fn occlusion(studio: &mut Studio, page: &mut Page, bricks: &Bricks) -> Result<(), LabError> {
    let heights = bricks.heights(1.0)?;
    let open = visibility(&heights, 1.0, &Occlusion::default(), &|_| ()).map_err(fault)?;
    let raw: Vec<[f32; 4]> = open.visibility.iter().map(|&v| [v, v, v, 1.0]).collect();
    let objects = vec![
        bricks.object(&bricks.colors, Some(&open)),
        bricks.object(&bricks.colors, None),
        bricks.object(&raw, None),
    ];
    let mut wall = Wall::new(studio, objects)?;
    let size = studio.pick(40, 240);
    let scale = studio.pick(3, 1);
    let (cones, bare, raw) = (0, 1, 2);
    // Without cones, the renderer would take the occlusion from the heights, which are flat here.
    let with = |cone_edge| ShadingOptions { cone_edge, relief_occlusion: false, ..Default::default() };
    let (opened, soft) = (with(ConeEdge::Open), with(ConeEdge::Soft));
    let shadow: [(&str, (usize, Technique, ShadingOptions), f32); 4] = [
        ("albedo", (bare, Technique::Constant, opened), 1.0),
        ("occlusion", (raw, Technique::Constant, opened), 0.5),
        ("without occlusion", (bare, Technique::Gloss, opened), 3.0),
        ("with occlusion", (cones, Technique::Gloss, opened), 3.0),
    ];
    let sunny: [(&str, (usize, Technique, ShadingOptions), f32); 4] = [
        ("occlusion", (raw, Technique::Constant, opened), 0.5),
        ("without occlusion", (bare, Technique::Gloss, opened), 2.0),
        ("with occlusion, edge open", (cones, Technique::Gloss, opened), 2.0),
        ("with occlusion, edge soft", (cones, Technique::Gloss, soft), 2.0),
    ];
    for (figure, line, panels, sun) in [
        (
            "Chan Figure 14",
            "The bricks in shadow, under surroundings of one radiance: the albedo, the occlusion, and pictures without and with occlusion \
            cones (--cone-occluders bounces, eq. 49).",
            shadow,
            None,
        ),
        (
            "Chan Figure 17",
            "The bricks in a sun 12° high: the occlusion, and pictures without occlusion cones, with cones for the surroundings alone \
            (--cone-edge open), and with cones that also shadow the sun (--cone-edge soft).",
            sunny,
            Some(LOW),
        ),
    ] {
        page.begin(figure, line);
        let (mut figures, mut means) = (Vec::new(), Vec::new());
        for (k, (caption, what, exposure)) in panels.into_iter().enumerate() {
            let shot = wall.draw(studio, size, 1.0, what, sun)?;
            means.push(mean_of(&shot));
            let name = format!("chan-bricks-{}-{k}", if sun.is_some() { "sun" } else { "shadow" });
            figures
                .push(studio.picture(&name, &shot.image, exposure, caption, vec![caption.to_owned()])?.enlarged(scale));
        }
        page.html.figures(&figures);
        if sun.is_none() {
            page.check("light that the cones leave", means[3] / means[2]);
            page.find(&format!("the cones leave {} of the light of the surroundings.", number(means[3] / means[2])));
        } else {
            page.check("light that the cones leave, edge open", means[2] / means[1]);
            page.check("light that the cones leave, edge soft", means[3] / means[1]);
            page.find(&format!(
                "the cones leave {} of the light with the edge open, and {} with the soft edge.",
                number(means[2] / means[1]),
                number(means[3] / means[1])
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The normals of the bricks belong to their displacement map, and relaxation converges to the direct solution.
    #[test]
    fn heights_of_the_bricks() {
        let bricks = Bricks::load(96).unwrap();
        let direct = bricks.heights(1.0).unwrap();
        let error = relative_difference(&direct, &bricks.displacement);
        let errors = SWEEPS.map(|sweeps| {
            relative_difference(&relaxed_heights(&bricks.slopes, Difference::Triangles, sweeps).unwrap(), &direct)
        });
        let usual = relative_difference(&bricks.heights(Integration::default().smoothness).unwrap(), &direct);
        println!("displacement: {error:.3}; sweeps {SWEEPS:?}: {errors:.4?}; default smoothness: {usual:.3}");
        assert!(error < 0.5 && errors[0] > errors[1] && errors[1] > errors[2]);
    }
}
