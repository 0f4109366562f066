//! Edge samples: outlines as smooth as of many samples, at one shaded sample per pixel.
//!
//! The geometry is drawn again with a grid of samples in every pixel, as often as it takes, each time moved by a part of the
//! grid's cell, with finer triangles where an object is small. Where such an edge sample sees the surface that the pixel's own sample
//! sees (the same object, in one plane with it), the pixel's shading is used again: it is that of the pixel's whole footprint
//! anyway. What sees another surface, across an outline, is filtered and shaded, each with the footprint of a whole pixel. So
//! the inside of a surface is shaded once, bit for bit as without edge samples.
//!
//! But maps know what lies beside a place, not what is seen of it, nor how patches bend. Where the footprint of a pixel is a
//! quarter of a patch of an atlas or more (less joins a part, from an eighth on), the edge samples that see the pixel's surface
//! are filtered, each with its part of the footprint, and their slope statistics joined in the pixel's frame
//! ([`slope_turn`](crate::reflectance::slopes::turn)) before the pixel is shaded, once.

use std::sync::Arc;

use glam::{IVec2, Vec2, Vec3};

use super::shade::{LightSet, LightingGpu};
use super::targets::{GBuffer, JoinedEdges, VisibleSurface};
use crate::gpu::{
    AddressMode, Buffer, Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, Result, Sampler, SharedStruct,
    SpecValue, Use, shared_struct,
};
use crate::render::camera::Camera;
use crate::render::settings::Needs;
use crate::render::surfaces::tessellation::{Lens, TessellationSettings};

/// Edge samples across a pixel in one drawing, at most.
pub const MAX_GRID: u32 = 16;
/// Vertices along a pixel when edge samples are drawn, at most, up to one per texel. More bring the outline nearer to that of the relief
/// and its shading farther from it, since what is seen of single bumps is not what their statistics are (docs/measurements/samples.md).
const VERTICES_PER_PIXEL: f32 = 6.0;
/// Vertices across an object then, where it is larger: its outline is a smaller part of it, and the vertices of whole
/// pixels show its bumps.
const VERTICES_ACROSS: f32 = 360.0;
/// Edge samples in one drawing, at most: they take 108 bytes each.
const MAX_DRAWN: u64 = 1 << 22;

/// The largest grid, up to `finest`, that makes up `samples` edge samples of a picture of `size` in several drawings: 1, 2, 4, 8 or
/// 16 samples across a pixel.
#[must_use]
pub fn edge_grid(samples: u32, size: (u32, u32), finest: u32) -> u32 {
    let pixels = u64::from(size.0) * u64::from(size.1);
    let fits = |&grid: &u32| samples.is_multiple_of(grid * grid) && u64::from(grid * grid) * pixels <= MAX_DRAWN;
    [16, 8, 4, 2].into_iter().filter(|&grid| grid <= finest).find(fits).unwrap_or(1)
}

/// The pixels, first and beyond the last, that can see anything in spheres of these centres and radii; all of them where a
/// sphere reaches the camera.
#[must_use]
pub fn area_of(spheres: &[(Vec3, f32)], camera: &Camera, size: (u32, u32)) -> [i32; 4] {
    let [x, y, forward] = camera.rays(size, Vec2::ZERO);
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for &(centre, radius) in spheres {
        let to = centre - camera.position;
        let depth = to.dot(forward);
        if depth + radius <= camera.near {
            continue;
        }
        if depth - radius <= camera.near {
            return [0, 0, size.0 as i32, size.1 as i32];
        }
        for (axis, ray) in [x, y].into_iter().enumerate() {
            // In units of half the picture, at depth 1.
            let (place, radius_here) = (to.dot(ray) / ray.length_squared(), radius / ray.length());
            // Nearer is farther out.
            let seen =
                |edge: f32, outward: f32| edge / if edge * outward > 0.0 { depth - radius } else { depth + radius };
            low[axis] = low[axis].min(seen(place - radius_here, -1.0));
            high[axis] = high[axis].max(seen(place + radius_here, 1.0));
        }
    }
    let size = IVec2::new(size.0 as i32, size.1 as i32);
    // A sample lies up to half a pixel from its centre.
    let pixel =
        |ndc: Vec2, margin: f32| ((ndc * 0.5 + 0.5) * size.as_vec2() + margin).clamp(Vec2::ZERO, size.as_vec2());
    let (first, last) = (pixel(low, -1.0).floor().as_ivec2(), pixel(high, 1.0).ceil().as_ivec2());
    let last = last.max(first);
    [first.x, first.y, last.x, last.y]
}

/// How finely an object of this bounding sphere is divided when edge samples are drawn. Of large objects nothing but `usual` is left.
#[must_use]
pub fn edge_tessellation(
    usual: TessellationSettings,
    (centre, radius): (Vec3, f32),
    lens: &Lens,
) -> TessellationSettings {
    let pixels = lens.pixels(centre, 2.0 * radius).max(1e-3);
    let vertices_per_pixel = (VERTICES_ACROSS / pixels).min(VERTICES_PER_PIXEL);
    TessellationSettings { to_texels: true, vertices_per_pixel, ..usual }
}

shared_struct! {
    /// Rays through a pixel's own sample and an edge sample (`EdgeRays` in `passes/edges/edges.glsl`).
    pub struct EdgeRays for "EdgeRays" {
        /// See [`Camera::rays`](crate::render::camera::Camera::rays); w: edge samples of each pixel.
        pub x: [f32; 4],
        /// As `x`; w unused.
        pub y: [f32; 4],
        /// The last ray of the pixel's own sample; w: near plane.
        pub pixel: [f32; 4],
        /// Of the edge sample; w: edge samples of each pixel in the drawings before.
        pub edge: [f32; 4],
        /// See [`area_of`].
        pub area: [i32; 4],
    }
}

impl EdgeRays {
    /// Of two samples' rays, which differ in the last alone, after `before` edge samples of each pixel out of `samples`.
    #[must_use]
    pub fn new(
        [x, y, pixel]: [Vec3; 3],
        [_, _, edge]: [Vec3; 3],
        near: f32,
        (before, samples): (u32, u32),
        area: [i32; 4],
    ) -> Self {
        let [x, y] = [x.extend(samples as f32), y.extend(0.0)].map(|v| v.to_array());
        Self { x, y, pixel: pixel.extend(near).to_array(), edge: edge.extend(before as f32).to_array(), area }
    }
}

/// The pass that marks what need not be shaded again.
pub struct EdgePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl EdgePass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/edges/edges.comp", &[], &[EdgeRays::LAYOUT])?,
            nearest: Sampler::new(gpu, "edges", Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Marks where the samples of `edge` see the surface that their `pixel` sees, and leaves them readable.
    pub fn record(
        &self,
        cmd: &mut Commands,
        (pixel, filtered): (&VisibleSurface, &GBuffer),
        edge: &VisibleSurface,
        rays: &EdgeRays,
    ) {
        cmd.transition(&edge.surface, Use::ComputeReadWrite);
        cmd.bind(
            &self.pipeline,
            &[
                ("pixel_surface", Descriptor::Sampled(pixel.surface.whole(), &self.nearest)),
                ("pixel_tangent", Descriptor::Sampled(pixel.tangent.whole(), &self.nearest)),
                ("pixel_depth", Descriptor::Sampled(pixel.depth.whole(), &self.nearest)),
                ("edge_surface", Descriptor::StorageImage(edge.surface.whole())),
                ("edge_tangent", Descriptor::Sampled(edge.tangent.whole(), &self.nearest)),
                ("edge_depth", Descriptor::Sampled(edge.depth.whole(), &self.nearest)),
                ("pixel_filtered", Descriptor::Sampled(filtered.surface.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(rays);
        let grid = edge.surface.mip_extent(0)[0] / pixel.surface.mip_extent(0)[0];
        let [left, top, right, bottom] = rays.area;
        let along = |first: i32, last: i32| grid * (last - first).max(1).unsigned_abs();
        cmd.dispatch_invocations(&self.pipeline, [along(left, right), along(top, bottom), 1]);
        cmd.transition(&edge.surface, Use::Sampled);
    }
}

/// The pass that joins the edge samples of each pixel.
pub struct JoinPass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl JoinPass {
    /// The pass for what a technique needs of slope statistics, and for lights.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, needs: Needs, lights: LightSet) -> Result<Self> {
        let own = vec![("SUN_SHADOWS", SpecValue::Bool(lights.sun && lights.shadows))];
        let spec = [needs.spec(), own].concat();
        Ok(Self {
            pipeline: ComputePipeline::new(
                gpu,
                "passes/edges/join.comp",
                &spec,
                &[EdgeRays::LAYOUT, LightingGpu::LAYOUT],
            )?,
            nearest: Sampler::new(gpu, "join", Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Adds a drawing of edge samples with their G-buffer and radiance to what was `joined` before, and to the
    /// G-buffer of the pixels, which stays readable.
    pub fn record(
        &self,
        cmd: &mut Commands,
        (edge, filtered, radiance): (&VisibleSurface, &GBuffer, &Image),
        pixel: &GBuffer,
        joined: &JoinedEdges,
        (lighting, shadow_map): (&Buffer, &Image),
        rays: &EdgeRays,
    ) {
        cmd.transition(radiance, Use::Sampled);
        for image in [&joined.others, &joined.shares] {
            if rays.edge[3] == 0.0 {
                cmd.image_barrier(image, Use::Undefined, Use::ComputeReadWrite);
            } else {
                cmd.transition(image, Use::ComputeReadWrite);
            }
        }
        let written = [&pixel.slopes, &pixel.material];
        for image in written {
            cmd.transition(image, Use::ComputeReadWrite);
        }
        cmd.bind(
            &self.pipeline,
            &[
                ("edge_surface", Descriptor::Sampled(edge.surface.whole(), &self.nearest)),
                ("edge_radiance", Descriptor::Sampled(radiance.whole(), &self.nearest)),
                ("edge_slopes", Descriptor::Sampled(filtered.slopes.whole(), &self.nearest)),
                ("edge_material", Descriptor::Sampled(filtered.material.whole(), &self.nearest)),
                ("edge_joined", Descriptor::Sampled(filtered.surface.whole(), &self.nearest)),
                ("lighting", Descriptor::Uniform(lighting)),
                ("others", Descriptor::StorageImage(joined.others.whole())),
                ("shares", Descriptor::StorageImage(joined.shares.whole())),
                ("shadow_map", Descriptor::Sampled(shadow_map.whole(), &self.nearest)),
                ("slopes", Descriptor::StorageImage(pixel.slopes.whole())),
                ("material", Descriptor::StorageImage(pixel.material.whole())),
                ("edge_depth", Descriptor::Sampled(edge.depth.whole(), &self.nearest)),
                ("pixel_surface", Descriptor::Sampled(pixel.surface.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(rays);
        let [width, height] = joined.others.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height, 1]);
        for image in written.into_iter().chain([&joined.others, &joined.shares]) {
            cmd.transition(image, Use::Sampled);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_holds_every_point_of_the_spheres_and_little_more() {
        let camera = Camera::looking_at(Vec3::new(-20.0, 3.0, 2.0), Vec3::new(1.0, 2.0, 0.0), 40.0);
        let size = (200, 120);
        for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(5.0, 9.0, 3.0), 2.0), (Vec3::new(-15.0, 2.0, 1.0), 0.7)]
        {
            let [left, top, right, bottom] = area_of(&[(centre, radius)], &camera, size).map(|v| v as f32);
            let clip = camera.clip_from_world(size, Vec2::ZERO);
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            for k in 0..2000 {
                let z = 1.0 - (2 * k + 1) as f32 / 2000.0;
                let (sine, cosine) = (k as f32 * 2.399_963).sin_cos();
                let point = centre + radius * Vec3::new(cosine * (1.0 - z * z).sqrt(), sine * (1.0 - z * z).sqrt(), z);
                let ndc = clip.project_point3(point).truncate();
                let pixel = ((ndc * 0.5 + 0.5) * Vec2::new(200.0, 120.0)).clamp(Vec2::ZERO, Vec2::new(200.0, 120.0));
                (low, high) = (low.min(pixel), high.max(pixel));
            }
            // A sample lies up to half a pixel away, and bounds are of whole pixels; a near sphere is seen wider than its middle.
            assert!(left <= low.x && top <= low.y && right >= high.x && bottom >= high.y, "{low} {high}");
            let room = Vec2::new(low.x - left, low.y - top).max(Vec2::new(right - high.x, bottom - high.y));
            assert!(
                room.max_element() < 2.5 + 0.2 * (high - low).max_element(),
                "{low} {high} in {left} {top} {right} {bottom}"
            );
        }
        assert_eq!(area_of(&[(camera.position, 1.0)], &camera, size), [0, 0, 200, 120], "around the camera");
        for hidden in [Vec3::new(0.0, 300.0, 0.0), Vec3::new(0.0, -300.0, 0.0), Vec3::new(-30.0, 3.0, 2.0)] {
            let [left, top, right, bottom] = area_of(&[(hidden, 1.0)], &camera, size);
            assert!(left <= right && top <= bottom && (right - left) * (bottom - top) == 0, "{hidden} is out of sight");
        }
        let [left, top, right, bottom] = area_of(&[], &camera, size);
        assert!(left <= right && top <= bottom && (right - left) * (bottom - top) == 0, "nothing");
    }

    #[test]
    fn large_objects_are_divided_as_always() {
        let lens = Lens { eye: Vec3::ZERO, focal_pixels: 1000.0, near: 0.1 };
        let usual = TessellationSettings::default();
        let per_pixel = |distance: f32| {
            let sphere = (Vec3::X * (distance + 1.0), 1.0);
            edge_tessellation(usual, sphere, &lens).vertices_per_pixel
        };
        // 2 metres are 20 pixels at 100 m, 200 at 10 m.
        assert_eq!(per_pixel(100.0), VERTICES_PER_PIXEL);
        assert!((per_pixel(10.0) - VERTICES_ACROSS / 200.0).abs() < 0.02, "{}", per_pixel(10.0));
        // Default triangles have a vertex every 2.8 pixels: nothing is added where less is asked for.
        assert!(per_pixel(1.0) < (2.0 * usual.pixels_per_triangle).sqrt().recip());
        assert!(per_pixel(-0.5) < 0.1, "around the camera");
        let far = edge_tessellation(usual, (Vec3::X * 50.0, 1.0), &lens);
        assert!(far.to_texels && far.pixels_per_triangle == usual.pixels_per_triangle);
    }

    #[test]
    fn grids_divide_the_samples_and_fit_into_memory() {
        for (samples, size, finest, grid) in [
            (256, (128, 128), MAX_GRID, 16),
            (64, (128, 128), MAX_GRID, 8),
            (64, (128, 128), 4, 4),
            (64, (128, 128), 1, 1),
            (8, (128, 128), 4, 2),
            (6, (128, 128), 4, 1),
            (64, (1280, 720), 4, 2),
            (64, (4096, 2160), 4, 1),
        ] {
            assert_eq!(edge_grid(samples, size, finest), grid, "{samples} of {size:?}");
        }
    }
}
