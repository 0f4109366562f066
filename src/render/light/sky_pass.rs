//! The sky pass: [`Sky`] into the faces of a cube map. `shaders-glsl/passes/light/sky_tables.comp` integrates the tables of
//! [`super::sky`] in three dispatches, `sky.comp` reads them per texel.

use std::sync::Arc;

use super::sky::{ALTITUDES, COLUMNS, ROWS, Sky};
use crate::gpu::{Buffer, Commands, ComputePipeline, Descriptor, Gpu, ImageView, Memory, Result, Use};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    sun: [f32; 3],
    haze: f32,
    albedo: [f32; 4],
    sunlight: [f32; 4],
    stage: u32,
}

impl Push {
    fn new(sky: &Sky, stage: u32) -> Self {
        let albedo = sky.albedo().as_vec3();
        let sunlight = sky.sunlight().as_vec3();
        Self {
            sun: sky.sun().as_vec3().to_array(),
            haze: sky.haze() as f32,
            albedo: albedo.extend(0.0).to_array(),
            sunlight: sunlight.extend(0.0).to_array(),
            stage,
        }
    }
}

/// The pass.
pub struct SkyPass {
    tables: ComputePipeline,
    faces: ComputePipeline,
    buffer: Buffer,
}

impl SkyPass {
    /// Creates the pipelines and the buffer of the tables (49 KiB).
    ///
    /// # Errors
    /// [`GpuError::Allocation`](crate::gpu::GpuError) or a failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let entries = ALTITUDES + 1 + 3 * ROWS * COLUMNS;
        Ok(Self {
            tables: ComputePipeline::new(gpu, "passes/light/sky_tables.comp", &[])?,
            faces: ComputePipeline::new(gpu, "passes/light/sky.comp", &[])?,
            buffer: Buffer::new(gpu, "sky tables", 16 * entries as u64, Memory::Device)?,
        })
    }

    /// Fills `faces`, mip 0 of an RGBA32F cube as an array, in [`Use::ComputeWrite`].
    pub fn record(&self, cmd: &mut Commands, sky: &Sky, faces: &ImageView) {
        let tables = (0, Descriptor::Storage(&self.buffer));
        // an earlier frame's sky may still be reading the tables
        cmd.memory_barrier(Use::ComputeRead, Use::ComputeWrite);
        cmd.bind(&self.tables, &[tables]);
        for (stage, groups) in [ALTITUDES, ROWS * COLUMNS / 64, 1].into_iter().enumerate() {
            cmd.push_constants(&Push::new(sky, stage as u32));
            cmd.dispatch([groups as u32, 1, 1]);
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeReadWrite);
        }
        let [width, height] = faces.extent();
        cmd.bind(&self.faces, &[tables, (1, Descriptor::StorageImage(faces))]);
        cmd.push_constants(&Push::new(sky, 0));
        cmd.dispatch_invocations(&self.faces, [width, height, 6]);
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::gpu::{reflect, shaders};

    #[test]
    fn push_constants_and_tables_lie_as_in_the_shaders() {
        // the fourth component of the first vector is `haze`
        let rust =
            [offset_of!(Push, sun), offset_of!(Push, albedo), offset_of!(Push, sunlight), offset_of!(Push, stage)];
        assert_eq!(offset_of!(Push, haze), 12);
        for shader in ["passes/light/sky_tables.comp", "passes/light/sky.comp"] {
            let spirv = shaders::spirv(shader).unwrap();
            let glsl = reflect::struct_offsets(spirv, "Push").unwrap();
            assert_eq!(glsl.iter().map(|(_, offset)| *offset as usize).collect::<Vec<_>>(), rust, "{shader}");
            let tables = reflect::struct_offsets(spirv, "SkyTables").unwrap();
            let starts = [0, 16 * ALTITUDES, 16 * (ALTITUDES + 1)];
            assert_eq!(tables.iter().map(|(_, offset)| *offset as usize).collect::<Vec<_>>(), starts, "{shader}");
        }
    }
}
