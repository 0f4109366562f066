//! The pass that blurs the environment for few lookups: a second cube whose levels have a smooth, round kernel
//! ([`kernel`](crate::reflectance::visible::kernel)). Each level is made from the one before, so a level costs a few tens
//! of lookups per texel.

use std::sync::Arc;

use crate::gpu::vk::Format;
use crate::gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, ImageDesc, ImageView, Result, Sampler,
    SharedStruct, Use, shared_struct,
};
use crate::reflectance::visible::kernel::{kernel_levels, kernel_variance, lookup_variance};

shared_struct! {
    /// A lattice of lookups.
    struct Push for "Push" {
        spacing: f32,
        falloff: f32,
        rings: i32,
    }
}

/// Rings of lookups for the first blurred level, whose source has texels that nothing has smoothed, and for the others.
const RINGS: [i32; 2] = [5, 2];
/// Deviation of the lattice's weights in units of its spacing, likewise.
const DEVIATION: [f64; 2] = [2.0, 1.1];

/// The cube, always in [`Use::Sampled`] between recordings, and its pass.
pub struct CubeLobes {
    cube: Image,
    /// Every level as faces to write, and as a cube to look up.
    levels: Vec<[ImageView; 2]>,
    pipeline: ComputePipeline,
    sampler: Sampler,
}

impl CubeLobes {
    /// The pass for environments with faces of `face_size` texels; the cube is undefined until it is recorded.
    ///
    /// # Errors
    /// [`GpuError::Allocation`](crate::gpu::GpuError), or a failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>, face_size: u32) -> Result<Self> {
        let levels = kernel_levels(face_size);
        let desc = ImageDesc::new(Format::R32G32B32A32_SFLOAT, face_size, face_size).cube().mips(levels).storage();
        let cube = Image::new(gpu, "environment lobes", desc)?;
        let views = |mip| Ok([cube.mip_array(mip)?, cube.mip_cube(mip)?]);
        Ok(Self {
            levels: (0..levels).map(views).collect::<Result<_>>()?,
            cube,
            pipeline: ComputePipeline::new(gpu, "passes/light/cube_lobes.comp", &[], &[Push::LAYOUT])?,
            sampler: Sampler::new(gpu, "environment lobes", Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Fills the cube from `environment`, a cube with box mips in [`Use::Sampled`].
    pub fn record(&self, cmd: &mut Commands, environment: &ImageView) {
        // The remembered use of the whole; each level is brought back to it below.
        cmd.image_barrier(&self.cube, Use::Undefined, Use::Sampled);
        let size = self.cube.desc().width;
        let mut source = environment;
        for (level, [faces, cube]) in self.levels.iter().enumerate() {
            let level = level as u32;
            cmd.mip_barrier(&self.cube, level..level + 1, 0..6, Use::Sampled, Use::ComputeWrite);
            let resources = [("source", Descriptor::Sampled(source, &self.sampler))];
            cmd.bind(&self.pipeline, &[&resources[..], &[("level", Descriptor::StorageImage(faces))]].concat());
            cmd.push_constants(&lattice(level, size));
            let [width, height] = faces.extent();
            cmd.dispatch_invocations(&self.pipeline, [width, height, 6]);
            cmd.mip_barrier(&self.cube, level..level + 1, 0..6, Use::ComputeWrite, Use::Sampled);
            if level > 0 {
                source = cube;
            }
        }
    }

    /// The cube map, for `samplerCube`.
    #[must_use]
    pub fn cube(&self) -> &ImageView {
        self.cube.whole()
    }

    /// The image behind it.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.cube
    }
}

/// The lattice that makes a level of a cube with faces of `size` texels from the one before it.
fn lattice(level: u32, size: u32) -> Push {
    if level == 0 {
        return Push { spacing: 0.0, falloff: 0.0, rings: 0 };
    }
    let kind = usize::from(level > 1);
    let (rings, falloff) = (RINGS[kind], 0.5 / (DEVIATION[kind] * DEVIATION[kind]));
    let add = kernel_variance(level, size) - lookup_variance(f64::from(level - 1), f64::from(size));
    // The lookups' mean cosine is that of a kernel of this variance.
    let cosine = |spacing: f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in -rings..=rings {
            for j in (-rings).max(-rings - i)..=rings.min(rings - i) {
                let square = f64::from(i * i + i * j + j * j);
                let weight = (-falloff * square).exp();
                sum += weight * (spacing * square.sqrt()).cos();
                weights += weight;
            }
        }
        sum / weights
    };
    let (mut low, mut high) = (0.0, 2.0 / f64::from(rings));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cosine(middle) > (-add).exp() { low = middle } else { high = middle }
    }
    Push { spacing: low as f32, falloff: falloff as f32, rings }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice coarser than the smoothness of what it looks up would show.
    #[test]
    fn lookups_are_no_farther_apart_than_what_they_see_is_wide() {
        for size in [16, 256] {
            for level in 2..kernel_levels(size) {
                let seen = lookup_variance(f64::from(level - 1), f64::from(size)).sqrt();
                let spacing = f64::from(lattice(level, size).spacing);
                println!("{size}, {level}: spacing {spacing:.4}, deviation of what is seen {seen:.4}");
                assert!(spacing < 1.9 * seen, "{spacing} {seen}");
            }
        }
    }
}
