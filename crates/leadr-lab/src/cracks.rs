//! Detects cracks in displaced surfaces by comparison with the undisplaced surface.
//!
//! A pixel must stay covered if the smooth surface covers every point from which relief can reach the pixel. The depth of a
//! pixel must not exceed the depth of the deepest bump. A deeper pixel is a crack, which shows the background, a back face,
//! or another surface.
//!
//! Bumps can also uncover hidden gaps between separate parts of a model. Such gaps appear at outlines in front of other
//! surfaces, and where a surface is steeper than [`STEEPEST`]. Pixels in such gaps are counted separately.

use std::sync::Arc;

use glam::Vec3;

use leadr_gpu::{Gpu, Result};
use leadr_maps::material::Relief;
use leadr_maps::{HeightMap, procedural};
use leadr_models::Model;
use leadr_render::camera::Camera;
use leadr_render::frame::{Layer, Renderer};
use leadr_render::light::environment::Environment;
use leadr_render::light::sky::Sky;
use leadr_render::scene::FrameState;
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::stage::{Lights, Stage};

/// The result of a crack search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Cracks {
    /// The number of pixels that show something behind the surface.
    pub cracks: usize,
    /// The number of cracked pixels at outlines and on steep surfaces, which may be gaps between separate parts.
    pub at_outlines: usize,
    /// The number of pixels where a crack would be detected.
    pub searched: usize,
    /// The number of pixels that the displaced surface covers.
    pub covered: usize,
}

impl std::ops::AddAssign for Cracks {
    fn add_assign(&mut self, other: Self) {
        self.cracks += other.cracks;
        self.at_outlines += other.at_outlines;
        self.searched += other.searched;
        self.covered += other.covered;
    }
}

/// The parameters of a crack search.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// The number of views around the model at each distance.
    pub views: u32,
    /// The width and height of the pictures in pixels.
    pub size: (u32, u32),
    /// The animation time in seconds.
    pub time: f64,
}

/// The camera distances of a search: a close-up, the whole model, and a model that is small in the picture.
pub const DISTANCES: [f32; 3] = [0.35, 1.0, 3.0];

/// The largest depth slope at which a smooth surface hides no gap, as the tangent of the surface's angle to the picture
/// plane.
pub const STEEPEST: f32 = 1.5;

/// The smallest depth step that separates two surfaces, in pixel widths beyond the neighbouring steps.
const JUMP: f32 = 0.5;

/// Returns rough repeating heights from 0 to 1, with bumps of a few texels.
pub fn rough_relief(scale: Option<f32>) -> Relief {
    let size = 64;
    let HeightMap { texels, .. } = procedural::gaussian(size, size, 5, 1.0, 3.0 / size as f32);
    let (low, high) = texels.iter().fold((f32::MAX, f32::MIN), |(low, high), &h| (low.min(h), high.max(h)));
    let texels = texels.iter().map(|h| (h - low) / (high - low)).collect();
    Relief { map: HeightMap { width: size, height: size, texels }, scale, in_widths: false, middle: 0.5 }
}

/// Adds rough relief to every material of a model.
pub fn roughened(mut model: Model, scale: Option<f32>) -> Model {
    model.materials.iter_mut().for_each(|material| material.relief = Some(rough_relief(scale)));
    model
}

/// Searches a model's stage for cracks. The stage's last object is the ground, which is left out.
///
/// # Errors
/// Fails if the device fails.
pub fn search(gpu: &Arc<Gpu>, mut stage: Stage, search: Search) -> Result<Cracks> {
    let Search { views: count, size, time } = search;
    stage.objects.pop();
    let corners = stage.objects.iter().flat_map(|object| &object.mesh.positions);
    let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
    let bump = |object: &leadr_render::scene::Object| {
        let heights = object.heights.iter().flat_map(|field| &field.map.texels);
        heights.fold(0.0f32, |bump, h| bump.max(h.abs())) * object.height_scale.abs()
    };
    let bump = stage.objects.iter().map(bump).fold(0.0, f32::max);
    let environment = Environment::from_sky(gpu, 16, &Sky::default())?;
    let mut renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), environment)?;
    let settings = RenderSettings { size, ..RenderSettings::default() };
    let mut all = Cracks::default();
    for distance in DISTANCES {
        for camera in views(count, 0.5 * (low + high), 0.5 * low.distance(high), distance) {
            let mut state = stage.state(time, &camera, &Lights::under(&Sky::default()));
            state.poses.pop();
            all += find(&mut renderer, &state, &settings, bump)?;
        }
    }
    Ok(all)
}

/// Searches one view for cracks. `bump` is the largest distance in metres between the displaced and the smooth surface at height scale 1.
///
/// # Errors
/// Fails if the device fails.
pub fn find(renderer: &mut Renderer, state: &FrameState, settings: &RenderSettings, bump: f32) -> Result<Cracks> {
    let settings = RenderSettings { samples: 1, shadows: false, shading: Technique::Constant.into(), ..*settings };
    let mut depths = |height_scale: f32| {
        let output = renderer.render(&FrameState { height_scale, ..state.clone() }, &settings)?;
        let depth = renderer.layer(Layer::Depth)?;
        let covered = output.color.iter().map(|pixel| pixel[3] > 0.0);
        Result::Ok(covered.zip(&depth).map(|(covered, depth)| covered.then_some(depth[0])).collect::<Vec<_>>())
    };
    let (smooth, displaced) = (depths(0.0)?, depths(state.height_scale)?);
    let bump = bump * state.height_scale.abs();
    let (width, height) = (settings.size.0 as usize, settings.size.1 as usize);
    let focal = state.camera.lens(settings.size.1).focal_pixels;
    let mut seen = Cracks { covered: displaced.iter().flatten().count(), ..Cracks::default() };
    for (i, shown) in displaced.iter().enumerate() {
        let (x, y) = (i % width, i / width);
        let Some(depth) = smooth[i] else { continue };
        let reach = (bump * focal / (depth - bump).max(1e-3 * depth)).ceil() as usize + 1;
        if x < reach || y < reach || x + reach >= width || y + reach >= height {
            continue;
        }
        let row = |row: usize| &smooth[row * width + x - reach..=row * width + x + reach];
        let mut around = (y - reach..=y + reach).flat_map(row);
        let Some(deepest) = around.try_fold(0.0f32, |deepest, depth| depth.map(|depth| deepest.max(depth))) else {
            continue;
        };
        seen.searched += 1;
        if shown.is_some_and(|depth| depth <= deepest + 1.5 * bump + 1e-3 * deepest) {
            continue;
        }
        seen.cracks += 1;
        let steps = Steps { depths: &smooth, pixel: deepest / focal, count: 2 * reach };
        let corner = (y - reach) * width + x - reach;
        let across = (0..=2 * reach).any(|row| steps.are_broken(corner + row * width, 1));
        let down = (0..=2 * reach).any(|column| steps.are_broken(corner + column, width));
        seen.at_outlines += usize::from(across || down);
    }
    Ok(seen)
}

/// The depth steps along rows and columns of a picture.
struct Steps<'a> {
    depths: &'a [Option<f32>],
    /// The width of a pixel in metres, at the depth of the surface.
    pixel: f32,
    count: usize,
}

impl Steps<'_> {
    /// Whether a step from `start` along `stride` is steeper than [`STEEPEST`] or jumps. A jump, for example at an occluding
    /// edge, differs from the steps on both sides. A crease differs from the step on one side only.
    fn are_broken(&self, start: usize, stride: usize) -> bool {
        let depth = |i: usize| self.depths[start + i * stride].unwrap_or(0.0);
        let step = |i: usize| (depth(i + 1) - depth(i)) / self.pixel;
        let jumps = |i: usize| {
            let (before, after) = (step(i) - step(i - 1), step(i) - step(i + 1));
            before * after > 0.0 && before.abs().min(after.abs()) > JUMP
        };
        (0..self.count).any(|i| step(i).abs() > STEEPEST) || (1..self.count - 1).any(jumps)
    }
}

/// Returns cameras spread evenly around a sphere. At a distance of 1, the sphere fills the picture.
pub fn views(count: u32, centre: Vec3, radius: f32, distance: f32) -> impl Iterator<Item = Camera> {
    let degrees: f32 = 35.0;
    let away = distance * radius / (0.5 * degrees.to_radians()).sin();
    (0..count).map(move |i| {
        let height = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let around = i as f32 * std::f32::consts::PI * (3.0 - 5.0f32.sqrt());
        let direction = (Vec3::new(around.cos(), around.sin(), 0.0) * (1.0 - height * height).sqrt()).with_z(height);
        Camera::looking_at(centre + away * direction, centre, degrees)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creases_are_unbroken_and_edges_broken() {
        let broken = |depths: &[f32]| {
            let depths: Vec<Option<f32>> = depths.iter().copied().map(Some).collect();
            Steps { depths: &depths, pixel: 0.1, count: depths.len() - 1 }.are_broken(0, 1)
        };
        // The depths are unbroken: a flat surface, a plane at 50 degrees, a cube edge, and an edge within a pixel.
        assert!(!broken(&[5.0; 7]));
        assert!(!broken(&[5.0, 5.12, 5.24, 5.36, 5.48]));
        assert!(!broken(&[5.1, 5.0, 4.9, 4.8, 4.9, 5.0, 5.1]));
        assert!(!broken(&[5.0, 5.0, 5.0, 5.05, 5.15, 5.25]));
        // The depths are broken: a plate in front of another, and a plane that is too steep.
        assert!(broken(&[5.0, 5.02, 5.04, 5.13, 5.15, 5.17]));
        assert!(broken(&[5.0, 5.2, 5.4, 5.6]));
    }
}
