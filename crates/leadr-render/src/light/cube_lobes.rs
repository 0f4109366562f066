//! The pass that blurs the environment into a second cube map, so that a pixel needs few lookups. The levels of this cube map have
//! a smooth, round kernel ([`kernel`](leadr_reflectance::visible::kernel)). Each level is made from the previous level with 19
//! lookups per texel. On an unsmoothed environment, the lookups for the first level would leave gaps. A pass with a denser lattice
//! therefore smooths the environment first.
//!
//! Texels are half floats if these can represent the environment, because hardware filters 32-bit floats four times as slowly.

use std::sync::Arc;

use leadr_gpu::vk::Format;
use leadr_gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, ImageDesc, ImageView, Result, Sampler,
    SharedStruct, Use, shared_struct,
};
use leadr_reflectance::visible::kernel::{kernel_levels, kernel_variance, lookup_variance};

shared_struct! {
    /// A lattice of lookups around a texel.
    struct Push for "Push" {
        weights: [f32; 4],
        tangents: [f32; 3],
        lod: f32,
        coarsens: f32,
        widening: f32,
    }
}

/// The squared distances of the three rings of six lookups from the centre, in lattice spacings.
const STARS: [f64; 3] = [1.0, 3.0, 4.0];
/// The standard deviation of the lookup weights, in lattice spacings.
const DEVIATION: f64 = 1.1;
/// The variance that the smoothing before the first level adds, in squared texels of the finest level. With less variance, the
/// power of a bright pixel would depend on its position, because the lookups are as far apart as the texels of the first level.
const SMOOTHING: f64 = 0.65;

/// The range of peak radiances that are stored as half floats. Half floats have a precision of 1/2000, or of 3e-8 below 6e-5.
const OF_HALVES: std::ops::Range<f32> = 1e-3..6e4;

/// One dispatch, whose source and target are indices into [`CubeLobes::views`].
struct Step {
    /// The source, or `None` to read the environment.
    source: Option<usize>,
    target: usize,
    push: Push,
}

/// The blurred cube and its pass. The cube is always in [`Use::Sampled`] between recordings.
pub struct CubeLobes {
    /// The blurred levels, for `samplerCube`.
    pub cube: Image,
    /// The source of the first level, or `None` for a smooth environment.
    smoothed: Option<Image>,
    /// The views of every level and of the smoothed source. Each entry is an array of faces to write, and a cube to sample.
    views: Vec<[ImageView; 2]>,
    steps: Vec<Step>,
    pipeline: ComputePipeline,
    sampler: Sampler,
}

impl CubeLobes {
    /// Creates the pass for environments with faces of `environment_size` texels. Faces of the blurred cube have `size` texels, at
    /// most `environment_size`. `smooth` is whether the environment has no detail as small as two texels of the blurred cube, and
    /// `brightest` is its peak radiance. The cube is undefined until the pass is recorded.
    pub fn new(gpu: &Arc<Gpu>, environment_size: u32, size: u32, smooth: bool, brightest: f32) -> Result<Self> {
        let levels = kernel_levels(size);
        let mip = (environment_size / size).max(1).ilog2();
        let (format, shader) = if OF_HALVES.contains(&brightest) {
            (Format::R16G16B16A16_SFLOAT, "passes/light/cube_lobes_half.comp")
        } else {
            (Format::R32G32B32A32_SFLOAT, "passes/light/cube_lobes.comp")
        };
        let image = |name, size, levels| {
            let desc = ImageDesc::new(format, size, size).cube().mips(levels).storage();
            Image::new(gpu, name, desc)
        };
        let view = |image: &Image, mip| Ok([image.mip_array(mip)?, image.mip_cube(mip)?]);
        let cube = image("environment lobes", size, levels)?;
        let mut views = (0..levels).map(|level| view(&cube, level)).collect::<Result<Vec<_>>>()?;
        let smoothed = if smooth { None } else { Some(image("smoothed environment", (size / 2).max(1), 1)?) };
        if let Some(smoothed) = &smoothed {
            views.push(view(smoothed, 0)?);
        }
        Ok(Self {
            cube,
            smoothed,
            views,
            steps: steps(mip, size, smooth),
            pipeline: ComputePipeline::new(gpu, shader, &[], &[Push::LAYOUT])?,
            sampler: Sampler::new(gpu, Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Fills the cube from `environment`, which is a cube with box-filtered mips in [`Use::Sampled`].
    pub fn record(&self, cmd: &mut Commands, environment: &Image) {
        let between = |cmd: &mut Commands, image: &Image, mip: u32, from: Use, to: Use| {
            cmd.mip_barrier(image, mip..mip + 1, 0..6, from, to);
        };
        // The use is tracked for the whole image. The loop below returns each level to this use.
        for image in [Some(&self.cube), self.smoothed.as_ref()].into_iter().flatten() {
            cmd.image_barrier(image, Use::Undefined, Use::Sampled);
        }
        for step in &self.steps {
            let (image, mip) = match &self.smoothed {
                Some(smoothed) if step.target + 1 == self.views.len() => (smoothed, 0),
                _ => (&self.cube, step.target as u32),
            };
            let faces = &self.views[step.target][0];
            let source = step.source.map_or(environment.whole(), |view| &self.views[view][1]);
            let resources =
                [("source", Descriptor::Sampled(source, &self.sampler)), ("level", Descriptor::StorageImage(faces))];
            between(cmd, image, mip, Use::Sampled, Use::ComputeWrite);
            cmd.bind(&self.pipeline, &resources);
            cmd.push_constants(&step.push);
            let [width, height] = faces.extent();
            cmd.dispatch_invocations(&self.pipeline, [width, height, 6]);
            between(cmd, image, mip, Use::ComputeWrite, Use::Sampled);
        }
    }
}

/// Returns all dispatches for a cube with faces of `size` texels. The finest level of the cube has the size of mip `mip` of the
/// environment.
fn steps(mip: u32, size: u32, smooth: bool) -> Vec<Step> {
    let levels = kernel_levels(size) as usize;
    let as_it_is =
        Push { weights: [1.0, 0.0, 0.0, 0.0], tangents: [0.0; 3], lod: mip as f32, coarsens: 0.0, widening: 0.0 };
    let mut steps = vec![Step { source: None, target: 0, push: as_it_is }];
    for target in 1..levels {
        let texel = |level: usize| 2.0 / f64::from(size >> level);
        let wanted = kernel_variance(target as u32, size);
        // These are the variances of bilinear lookups and of box-filtered mips, in squared texels.
        let (bilinear, of_box) = (1.0 / 6.0, 0.25);
        let push = if target > 1 {
            let seen = lookup_variance(target as f64 - 1.0, f64::from(size));
            lattice(wanted - seen, bilinear * texel(target - 1).powi(2))
        } else if smooth {
            let seen = of_box * texel(1).powi(2);
            Push { lod: mip as f32 + 1.0, ..lattice(wanted - seen, seen) }
        } else {
            let smoothing = SMOOTHING * texel(0).powi(2);
            let push = Push { lod: mip as f32, coarsens: 1.0, ..lattice(smoothing, 0.0) };
            steps.push(Step { source: None, target: levels, push });
            let lookup = bilinear * texel(1).powi(2);
            lattice(wanted - of_box * texel(0).powi(2) - smoothing - lookup, lookup)
        };
        let source = match target {
            1 if smooth => None,
            1 => Some(levels),
            _ => Some(target - 1),
        };
        steps.push(Step { source, target, push });
    }
    steps
}

/// Returns a lattice that adds `variance`. `shrinks` is the part of the lookups' variance that scales with the texel size of the
/// source.
fn lattice(variance: f64, shrinks: f64) -> Push {
    let weights = STARS.map(|square| (-0.5 * square / (DEVIATION * DEVIATION)).exp());
    let sum = 1.0 + 6.0 * weights.iter().sum::<f64>();
    // The lookups and a kernel with this variance have equal mean cosines.
    let cosine = |spacing: f64| {
        let rings: f64 =
            weights.iter().zip(STARS).map(|(weight, square)| weight * (spacing * square.sqrt()).cos()).sum();
        (1.0 + 6.0 * rings) / sum
    };
    let (mut low, mut high) = (0.0, 0.7);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cosine(middle) > (-variance).exp() { low = middle } else { high = middle }
    }
    Push {
        weights: [1.0, weights[0], weights[1], weights[2]].map(|weight| (weight / sum) as f32),
        tangents: STARS.map(|square| (low * square.sqrt()).tan() as f32),
        lod: 0.0,
        coarsens: 0.0,
        widening: (shrinks / variance) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that no lattice is coarser than the blur of its source, which would be visible.
    #[test]
    fn lookup_spacing_is_within_lookup_width() {
        for size in [16, 256] {
            for Step { source, target, push } in steps(0, size, false).into_iter().skip(1) {
                let texel = 2.0 / f64::from(size);
                let seen = match source {
                    None => 0.25 * texel * texel,
                    Some(source) if source > target => (0.25 + SMOOTHING + 4.0 / 6.0) * texel * texel,
                    Some(source) => lookup_variance(source as f64, f64::from(size)),
                };
                let spacing = f64::from(push.tangents[0]).atan();
                println!("{size}, level {target}: spacing {spacing:.4}, deviation of what is seen {:.4}", seen.sqrt());
                assert!(spacing < 1.9 * seen.sqrt(), "{spacing} {seen}");
            }
        }
    }
}
