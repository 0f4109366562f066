//! The sky pass, which draws a [`Sky`] into the faces of a cube map. `shaders-glsl/passes/light/sky_tables.comp` integrates the
//! tables of [`super::sky`] in three dispatches, and `sky.comp` looks the tables up for each texel.

use std::sync::Arc;

use super::sky::{ALTITUDES, COLUMNS, ROWS, Sky};
use leadr_gpu::{
    Buffer, Commands, ComputePipeline, Descriptor, Gpu, ImageView, Memory, Result, SharedStruct, Use, shared_struct,
};

shared_struct! {
    struct Push for "Push" {
        /// The direction toward the sun in xyz, and the extinction of the haze in w.
        sun: [f32; 4],
        albedo: [f32; 4],
        sunlight: [f32; 4],
        stage: u32,
    }
}

shared_struct! {
    /// The sky tables, which exist only on the device.
    struct SkyTablesGpu for "SkyTables" {
        multiple: [[f32; 4]; ALTITUDES],
        ground: [f32; 4],
        view: [[f32; 4]; 3 * ROWS * COLUMNS],
    }
}

impl Push {
    fn new(sky: &Sky, stage: u32) -> Self {
        Self {
            sun: sky.sun().as_vec3().extend(sky.haze() as f32).to_array(),
            albedo: sky.albedo().as_vec3().extend(0.0).to_array(),
            sunlight: sky.sunlight().as_vec3().extend(0.0).to_array(),
            stage,
        }
    }
}

/// The sky pass.
pub struct SkyPass {
    tables: ComputePipeline,
    faces: ComputePipeline,
    buffer: Buffer,
}

impl SkyPass {
    /// Creates the pipelines and the buffer of the tables (49 KiB).
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let structs = [Push::LAYOUT, SkyTablesGpu::LAYOUT];
        Ok(Self {
            tables: ComputePipeline::new(gpu, "passes/light/sky_tables.comp", &[], &structs)?,
            faces: ComputePipeline::new(gpu, "passes/light/sky.comp", &[], &structs)?,
            buffer: Buffer::new(gpu, "sky tables", size_of::<SkyTablesGpu>() as u64, Memory::Device)?,
        })
    }

    /// Fills `faces`, which is mip 0 of an RGBA32F cube, as an array in [`Use::ComputeWrite`].
    pub fn record(&self, cmd: &mut Commands, sky: &Sky, faces: &ImageView) {
        let tables = ("Tables", Descriptor::Storage(&self.buffer));
        // The sky pass of an earlier frame may still be reading the tables.
        cmd.memory_barrier(Use::ComputeRead, Use::ComputeWrite);
        cmd.bind(&self.tables, &[tables]);
        for (stage, groups) in [ALTITUDES, ROWS * COLUMNS / 64, 1].into_iter().enumerate() {
            cmd.push_constants(&Push::new(sky, stage as u32));
            cmd.dispatch([groups as u32, 1, 1]);
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeReadWrite);
        }
        let [width, height] = faces.extent();
        cmd.bind(&self.faces, &[tables, ("cube", Descriptor::StorageImage(faces))]);
        cmd.push_constants(&Push::new(sky, 0));
        cmd.dispatch_invocations(&self.faces, [width, height, 6]);
    }
}
