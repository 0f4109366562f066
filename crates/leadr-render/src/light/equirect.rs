//! The equirect pass, which resamples an equirectangular image to the faces of a cube map.
//!
//! By convention, z is up in the world, row 0 is at +z, and the centre of the image is +x. Columns run clockwise seen from above,
//! which is to the right for a viewer: `u = ½ − atan2(y, x)/2π`, `v = θ/π`.
//!
//! A sun that is one pixel wide must keep its power. The image is therefore first resampled to a size that the cube can hold, in 64
//! bits and weighted by solid angle. The resampled texels are about square on the sphere, even near the poles. Then each cube texel
//! averages at least four samples per image texel along each axis, weighted by solid angle.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use leadr_gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, ImageView, Result, Sampler, SharedStruct,
    shared_struct,
};
use leadr_maps::RgbImage;

/// Returns the largest useful width of the equirectangular image for a face size. The width limits the footprint of the sampler.
fn widest(face_size: u32) -> u32 {
    (8 * face_size).max(8)
}

/// Returns the width, the height and the texels of the image that the pass reads. The texels are RGBA with alpha 1, and the width
/// is at most eight cube faces. Rows near the poles are smoothed to texels that are about square on the sphere. Every row keeps its
/// power, because the sums have 64 bits. `instead` lists texels to replace, by ascending index.
pub fn prepare(image: &RgbImage, instead: &[(usize, [f32; 3])], face_size: u32) -> (u32, u32, Vec<[f32; 4]>) {
    let (w, h) = (image.width.min(widest(face_size)), image.height.min(widest(face_size) / 2));
    let source_width = image.width as usize;
    let mut texels = Vec::with_capacity(w as usize * h as usize);
    let mut wide = vec![DVec3::ZERO; source_width];
    let mut changed = Vec::new();
    for j in 0..h {
        // Rows are averaged, and each row is weighted by the solid angle of its band.
        let scale = f64::from(image.height) / f64::from(h);
        let (top, bottom) = (f64::from(j) * scale, f64::from(j + 1) * scale);
        let cos = |row: f64| (PI * row / f64::from(image.height)).cos();
        wide.fill(DVec3::ZERO);
        for i in top as u32..(bottom.ceil() as u32).min(image.height) {
            let (low, high) = (top.max(f64::from(i)), bottom.min(f64::from(i + 1)));
            if high <= low {
                continue;
            }
            let weight = (cos(low) - cos(high)) / (cos(top) - cos(bottom));
            let (start, end) = (i as usize * source_width, (i as usize + 1) * source_width);
            let mut row = &image.texels[start..end];
            let changes = &instead[instead.partition_point(|t| t.0 < start)..instead.partition_point(|t| t.0 < end)];
            if !changes.is_empty() {
                changed.clear();
                changed.extend_from_slice(row);
                for &(index, texel) in changes {
                    changed[index - start] = texel;
                }
                row = &changed;
            }
            for (sum, &texel) in wide.iter_mut().zip(row) {
                *sum += weight * Vec3::from(texel).as_dvec3();
            }
        }
        // Columns are averaged over boxes. A box is as wide as a target texel or, near the poles, as wide as a texel is high.
        let sin = (PI * (f64::from(j) + 0.5) / f64::from(h)).sin();
        let texel_width = f64::from(image.width) / f64::from(w);
        let box_width = (texel_width * (1.0 / sin).max(1.0)).min(f64::from(image.width));
        let sums = RunningSums::new(&wide);
        for i in 0..w {
            let centre = (f64::from(i) + 0.5) * texel_width;
            let mean = sums.mean(centre - box_width / 2.0, centre + box_width / 2.0);
            texels.push(mean.as_vec3().extend(1.0).to_array());
        }
    }
    (w, h, texels)
}

/// The prefix sums of a row that wraps around the sphere, from 0 to the sum of the whole row.
struct RunningSums(Vec<DVec3>);

impl RunningSums {
    fn new(row: &[DVec3]) -> Self {
        let mut sums = vec![DVec3::ZERO];
        sums.extend(row.iter().scan(DVec3::ZERO, |sum, &texel| {
            *sum += texel;
            Some(*sum)
        }));
        Self(sums)
    }

    /// Returns the integral from column 0 to `x`, for any real `x`.
    fn until(&self, x: f64) -> DVec3 {
        let Self(sums) = self;
        let n = sums.len() - 1;
        let turns = (x / n as f64).floor();
        let within = x - turns * n as f64;
        let i = (within as usize).min(n - 1);
        turns * sums[n] + sums[i] + (within - i as f64) * (sums[i + 1] - sums[i])
    }

    fn mean(&self, from: f64, to: f64) -> DVec3 {
        // Near a bright sun, rounding can make a difference of sums slightly negative.
        ((self.until(to) - self.until(from)) / (to - from)).max(DVec3::ZERO)
    }
}

shared_struct! {
    struct Push for "Push" {
        /// The number of samples along each axis of a texel.
        samples: u32,
    }
}

/// The equirect pass.
pub struct EquirectPass {
    pipeline: ComputePipeline,
    sampler: Sampler,
}

impl EquirectPass {
    /// Creates the pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/light/equirect.comp", &[], &[Push::LAYOUT])?,
            sampler: Sampler::new(gpu, Filter::Bilinear, AddressMode::Repeat)?,
        })
    }

    /// Fills `faces` from `equirect`, which is the image of [`prepare`] in [`Use::Sampled`](leadr_gpu::Use). `faces` is mip 0 of a
    /// cube, as an array in [`Use::ComputeWrite`](leadr_gpu::Use).
    pub fn record(&self, cmd: &mut Commands, equirect: &ImageView, faces: &ImageView) {
        let (source, size) = (equirect.extent()[0], faces.extent()[0]);
        // This is the number of image texels per cube texel at the centre of a face, where cube texels are largest.
        let across = 2.0 / f64::from(size) * f64::from(source) / (2.0 * PI);
        let samples = ((4.0 * across).ceil() as u32).clamp(2, 16);
        cmd.bind(
            &self.pipeline,
            &[("equirect", Descriptor::Sampled(equirect, &self.sampler)), ("cube", Descriptor::StorageImage(faces))],
        );
        cmd.push_constants(&Push { samples });
        cmd.dispatch_invocations(&self.pipeline, [size, size, 6]);
    }
}
