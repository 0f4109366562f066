//! The sea of the reference. Rays are marched through the displaced waves, and slopes are not filtered. The reference must resolve
//! every wave up to the horizon and the occlusion between waves, which tessellation cannot do.

use std::sync::Arc;

use glam::Mat3;

use super::fields::{CascadeGpu, Content, OceanFields, RESOLUTIONS};
use super::filter::WaterGpu;
use crate::passes::targets::{GBuffer, GeometryTargets, VisibleSurface};
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object_view::Viewpoint;
use crate::surfaces::ocean::mesh::EARTH;
use crate::surfaces::ocean::waves::Cascade;
use leadr_gpu::{
    AddressMode, Buffer, Commands, Depth, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result, Sampler,
    SharedStruct, Topology, shared_struct,
};

/// The bound on the height of the waves, in standard deviations. One sample in 10⁸ lies beyond the bound.
const HEIGHT_BOUND: f64 = 5.7;
/// How many times more samples a tile has along one side than a tile of the drawn sea, up to the largest transform. Without it,
/// linear interpolation would halve the slope of waves that are three samples long.
const OVERSAMPLING: u32 = 2;
/// The slope bound for ray steps, in standard deviations. Rays still hit steeper waves, unless such a wave is narrower than a step.
const SLOPE_BOUND: f64 = 3.5;

shared_struct! {
    /// The rays from a viewpoint.
    pub struct RaysGpu for "View" {
        rays: [[f32; 4]; 3],
        eye: [f32; 4],
        centre: [f32; 4],
    }
}

/// Returns two bounds for each cascade. One is for the heights of all later cascades, and one for the slopes of all cascades up to
/// this one.
fn limits(deviations: &[[f64; 2]]) -> Vec<[f32; 2]> {
    let square = |part: &[[f64; 2]], c: usize| part.iter().map(|d| d[c] * d[c]).sum::<f64>().sqrt();
    (1..=deviations.len())
        .map(|i| {
            let rest = HEIGHT_BOUND * square(&deviations[i..], 0);
            [rest as f32, (SLOPE_BOUND * square(&deviations[..i], 1)) as f32]
        })
        .collect()
}

/// The passes of the reference, and the waves that they read. Clones share both.
#[derive(Clone)]
pub struct OceanMarch {
    fields: OceanFields,
    march: GraphicsPipeline,
    exact: GraphicsPipeline,
    limits: Buffer,
    bound: f32,
    repeat: Sampler,
    nearest: Sampler,
}

impl OceanMarch {
    /// Creates the passes for these waves.
    pub fn new(gpu: &Arc<Gpu>, cascades: &[Cascade], numbering: Numbering) -> Result<Self> {
        let deviations: Vec<_> = cascades.iter().map(Cascade::deviations).collect();
        let factor = |c: &Cascade| if c.resolution * OVERSAMPLING <= *RESOLUTIONS.end() { OVERSAMPLING } else { 1 };
        let finer: Vec<_> = cascades.iter().map(|c| c.oversampled(factor(c))).collect();
        let march = GraphicsDesc {
            vertex: "passes/fullscreen.vert",
            fragment: Some("passes/ocean/march.frag"),
            colors: &GeometryTargets::FORMATS,
            depth: Some(Depth::default()),
            spec: &[numbering.spec()],
            structs: &[RaysGpu::LAYOUT, CascadeGpu::LAYOUT],
            ..Default::default()
        };
        let exact = GraphicsDesc {
            vertex: "passes/ocean/filter.vert",
            fragment: Some("passes/ocean/exact.frag"),
            colors: &GBuffer::FORMATS,
            topology: Topology::Points,
            spec: &[numbering.spec()],
            structs: &[WaterGpu::LAYOUT, CascadeGpu::LAYOUT],
            ..Default::default()
        };
        Ok(Self {
            fields: OceanFields::new(gpu, &finer, Content::Derivatives)?,
            march: GraphicsPipeline::new(gpu, "ocean march", &march)?,
            exact: GraphicsPipeline::new(gpu, "ocean exact", &exact)?,
            limits: Buffer::from_slice(gpu, "ocean limits", &limits(&deviations))?,
            bound: (HEIGHT_BOUND * deviations.iter().map(|d| d[0] * d[0]).sum::<f64>().sqrt()) as f32,
            repeat: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Returns the rays from a viewpoint. `level` is the height of the water at rest.
    pub fn rays(&self, from: &Viewpoint, level: f32) -> RaysGpu {
        let (clip_from_world, lens, eye) = (from.clip_from_world, from.lens, from.lens.eye);
        // In clip space, x, y and w are linear in the direction from the eye, and w is the length along the view axis.
        let rows = clip_from_world.transpose();
        let linear = Mat3::from_cols(rows.x_axis.truncate(), rows.y_axis.truncate(), rows.w_axis.truncate());
        let rays = linear.transpose().inverse();
        RaysGpu {
            rays: [rays.x_axis, rays.y_axis, rays.z_axis].map(|v| v.extend(0.0).to_array()),
            eye: [eye.z - level, 0.5 / EARTH, lens.near, self.bound],
            centre: [eye.x, eye.y, 0.0, 0.0],
        }
    }

    /// The waves.
    pub fn fields(&self) -> &OceanFields {
        &self.fields
    }

    /// Draws into the active targets of the geometry pass. `rays` is a [`RaysGpu`] block.
    pub fn draw_geometry(&self, cmd: &mut Commands, rays: &Buffer) {
        cmd.bind(
            &self.march,
            &[
                ("view", Descriptor::Uniform(rays)),
                ("Cascades", Descriptor::Storage(&self.fields.cascades)),
                ("Limits", Descriptor::Storage(&self.limits)),
                ("displacement", Descriptor::Sampled(self.fields.displacement.whole(), &self.repeat)),
            ],
        );
        cmd.draw(0..3, 0..1);
    }

    /// Draws into the active G-buffer. `water` is the block of `passes/ocean/water.glsl`.
    pub fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, water: &Buffer) {
        cmd.bind(
            &self.exact,
            &[
                ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                ("displacement", Descriptor::Sampled(self.fields.displacement.whole(), &self.repeat)),
                ("slopes", Descriptor::Sampled(self.fields.slopes.whole(), &self.repeat)),
                ("Cascades", Descriptor::Storage(&self.fields.cascades)),
                ("water", Descriptor::Uniform(water)),
                ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            ],
        );
        visible.tiles.draw(cmd);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_shrink_with_the_waves() {
        let limits = limits(&[[3.0, 0.3], [4.0, 0.4]]);
        let near = |a: f32, b: f64| (f64::from(a) - b).abs() < 1e-5;
        assert!(near(limits[0][0], HEIGHT_BOUND * 4.0) && near(limits[0][1], SLOPE_BOUND * 0.3));
        assert!(limits[1][0] == 0.0 && near(limits[1][1], SLOPE_BOUND * 0.5));
    }
}
