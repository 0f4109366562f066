//! The material of a surface on the device: what of it is filtered beside its slopes, each with a mip chain of means over the
//! texels' areas.
//!
//! * colour, sRGB: albedo, averaged in linear light, and the root of the roughness `α`, averaged as the variance `α²`
//!   (LEADR section 4.1)
//! * reflectance at normal incidence, sRGB
//! * two roughnesses, halves: [`mixed_roughness`](crate::reflectance::facets::mixed_roughness)

use std::sync::Arc;

use ash::vk;
use half::f16;
use rayon::prelude::*;

use super::displacement::Border;
use crate::gpu::{Gpu, GpuError, Image, ImageDesc, Result};
use crate::maps::material::alpha_of;
use crate::maps::moments::coverage;
use crate::maps::srgb::{linear_of_srgb8, srgb8_from_linear};
use crate::render::scene::MaterialMap;

/// Format of the two roughnesses.
pub const MIXED_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// The images of a material; single texels in place of those that it lacks.
pub struct MaterialImages {
    /// Albedo and the root of `α`.
    pub color: Image,
    /// Reflectance at normal incidence.
    pub f0: Image,
    /// Share of the rougher texels, and the parts of the mean `α²` in them and in the others.
    pub mixed: Image,
    /// Whether there is a reflectance.
    pub has_f0: bool,
    /// Whether there are two roughnesses.
    pub is_mixed: bool,
}

impl MaterialImages {
    /// Uploads a material with its mips. In an atlas of tiles the mips end where a tile is one texel.
    ///
    /// # Errors
    /// [`GpuError::Usage`] where reflectance and colours differ in size; memory that is short, or a Vulkan call that failed.
    pub fn new(gpu: &Arc<Gpu>, name: &str, map: Option<MaterialMap>, border: Border) -> Result<Self> {
        let none = |what: &str, format| {
            let image = Image::new(gpu, &format!("{name} no {what}"), ImageDesc::new(format, 1, 1))?;
            image.write(0, 0, &vec![u8::MAX; image.texel_bytes()? as usize])?;
            Ok::<_, GpuError>(image)
        };
        let srgb = vk::Format::R8G8B8A8_SRGB;
        let Some(MaterialMap { width, height, colors, f0, rough_from }) = map else {
            return Ok(Self {
                color: none("colour", srgb)?,
                f0: none("reflectance", srgb)?,
                mixed: none("roughness", MIXED_FORMAT)?,
                has_f0: false,
                is_mixed: false,
            });
        };
        let size = [width, height];
        let (has_f0, is_mixed) = (f0.is_some(), rough_from.is_some());
        if f0.as_ref().is_some_and(|f0| f0.len() != colors.len()) {
            let fault = "reflectance and colours differ in size".to_owned();
            return Err(GpuError::Usage { name: format!("material of {name}"), fault });
        }
        let image = |what: &str, format| {
            let desc = ImageDesc::new(format, width, height).full_mips();
            let mips = match border {
                Border::Tiles(layout) => layout.tile.ilog2() + 1,
                Border::Wrap | Border::Clamp => desc.mips,
            };
            Image::new(gpu, &format!("{name} {what}"), desc.mips(mips))
        };
        let mixed = match rough_from {
            Some(threshold) => {
                let mixed = image("roughness", MIXED_FORMAT)?;
                let table = classes_of_codes(threshold);
                let texels = colors.par_iter().map(|texel| table[usize::from(texel[3])]).collect();
                write_mips(&mixed, size, texels, halves, halve)?;
                mixed
            }
            None => none("roughness", MIXED_FORMAT)?,
        };
        let codes = Codes::new();
        let write = |image: &Image, texels| {
            write_mips(image, size, texels, <[_]>::to_vec, |texels, from, to| codes.halve(texels, from, to))
        };
        let color = image("colour", srgb)?;
        write(&color, colors)?;
        let f0 = match f0 {
            Some(texels) => {
                let f0 = image("reflectance", srgb)?;
                write(&f0, texels)?;
                f0
            }
            None => none("reflectance", srgb)?,
        };
        Ok(Self { color, f0, mixed, has_f0, is_mixed })
    }
}

/// For every code of a roughness: whether it is at least `threshold`, and its `α²`, in the rougher or in the smoother class.
fn classes_of_codes(threshold: f32) -> [[f32; 4]; 256] {
    std::array::from_fn(|code| {
        let alpha = alpha_of(code as u8);
        let square = alpha * alpha;
        if alpha >= threshold { [1.0, square, 0.0, 0.0] } else { [0.0, 0.0, square, 0.0] }
    })
}

fn halves(texels: &[[f32; 4]]) -> Vec<[f16; 4]> {
    texels.iter().map(|texel| texel.map(f16::from_f32)).collect()
}

/// Writes `texels` and the levels below. `stored`: as the image holds them; `halve`: the next level, of given sizes.
fn write_mips<T, S: bytemuck::Pod>(
    image: &Image,
    mut size: [u32; 2],
    mut texels: Vec<T>,
    stored: impl Fn(&[T]) -> Vec<S>,
    halve: impl Fn(&[T], [u32; 2], [u32; 2]) -> Vec<T>,
) -> Result<()> {
    for mip in 0..image.desc().mips {
        if mip > 0 {
            let smaller = size.map(|side| (side / 2).max(1));
            texels = halve(&texels, size, smaller);
            size = smaller;
        }
        image.write(mip, 0, &stored(&texels))?;
    }
    Ok(())
}

/// Means over the part of a level under each texel of the next: `mean` of texels with their weights, which sum to 1.
fn reduce<T: Copy + Sync, U: Send>(
    texels: &[T],
    from: [u32; 2],
    to: [u32; 2],
    mean: impl Fn(&mut dyn Iterator<Item = (T, f32)>) -> U + Sync,
) -> Vec<U> {
    let (columns, rows) = (coverage(from[0], to[0]), coverage(from[1], to[1]));
    let width = from[0] as usize;
    rows.par_iter()
        .flat_map_iter(|row| {
            let mean = &mean;
            columns.iter().map(move |column| {
                mean(&mut row.iter().flat_map(|&(y, down)| {
                    column.iter().map(move |&(x, across)| (texels[y * width + x], (down * across) as f32))
                }))
            })
        })
        .collect()
}

fn halve(texels: &[[f32; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[f32; 4]> {
    reduce(texels, from, to, |parts| {
        parts.fold([0.0; 4], |sum, (texel, weight)| std::array::from_fn(|i| sum[i] + weight * texel[i]))
    })
}

/// What the codes of colours and roughnesses stand for.
pub(super) struct Codes {
    linear: [f32; 256],
    /// `α²` of the codes of roughness.
    variance: [f32; 256],
}

impl Codes {
    pub(super) fn new() -> Self {
        let variance = std::array::from_fn(|code| alpha_of(code as u8).powi(2));
        Self { linear: linear_of_srgb8(), variance }
    }

    /// Linear colour and `α²` of a texel.
    pub(super) fn linear(&self, [r, g, b, a]: [u8; 4]) -> [f32; 4] {
        let [r, g, b] = [r, g, b].map(|code| self.linear[usize::from(code)]);
        [r, g, b, self.variance[usize::from(a)]]
    }

    fn halve(&self, texels: &[[u8; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[u8; 4]> {
        let codes = |[r, g, b, variance]: [f32; 4]| {
            let [r, g, b] = [r, g, b].map(srgb8_from_linear);
            [r, g, b, (variance.sqrt().sqrt() * 255.0 + 0.5) as u8]
        };
        let width = from[0] as usize;
        if from == to.map(|side| 2 * side) {
            // Four texels each, without tables of weights.
            return (0..to[1] as usize)
                .into_par_iter()
                .flat_map_iter(|y| {
                    let rows = [2 * y * width, (2 * y + 1) * width];
                    (0..to[0] as usize).map(move |x| {
                        let four =
                            [rows[0], rows[0] + 1, rows[1], rows[1] + 1].map(|at| self.linear(texels[at + 2 * x]));
                        codes(std::array::from_fn(|i| 0.25 * four.iter().map(|texel| texel[i]).sum::<f32>()))
                    })
                })
                .collect();
        }
        reduce(texels, from, to, |parts| {
            codes(parts.fold([0.0; 4], |sum, (texel, weight)| {
                let texel = self.linear(texel);
                std::array::from_fn(|i| sum[i] + weight * texel[i])
            }))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::material::alpha_code;

    #[test]
    fn mips_average_light_and_variance_not_codes() {
        let [dark, rough] = [[0, 255, 10, alpha_code(0.0)], [255, 255, 10, alpha_code(0.5)]];
        let half = Codes::new().halve(&[dark, rough, dark, rough], [2, 2], [1, 1]);
        let rough = alpha_of(alpha_code(0.5));
        assert_eq!(half, [[188, 255, 10, alpha_code(rough * 0.5f32.sqrt())]]);
        // The mean of the codes would be much smoother.
        assert!(alpha_of(half[0][3]) > 1.3 * alpha_of(alpha_code(0.5) / 2));
    }

    #[test]
    fn odd_rows_and_columns_count() {
        let (black, white) = ([0, 0, 0, 255], [255, 255, 255, 255]);
        let half = Codes::new().halve(&[black, black, white, black, black, white, black, black, white], [3, 3], [1, 1]);
        assert_eq!(half, [[156, 156, 156, 255]]);
        // A third, as sRGB.
        assert!((linear_of_srgb8()[156] - 1.0 / 3.0).abs() < 2e-3);
        let even = halve(&[[1.0; 4], [0.0; 4], [0.0; 4]], [3, 1], [1, 1]);
        assert!((even[0][0] - 1.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn classes_split_the_variance() {
        let table = classes_of_codes(0.3);
        for alpha in [0.1, 0.6] {
            let [share, rough, smooth, _] = table[usize::from(alpha_code(alpha))];
            assert_eq!(share, if alpha > 0.3 { 1.0 } else { 0.0 });
            assert!((rough + smooth - alpha * alpha).abs() < 4e-3 && rough * smooth == 0.0);
        }
    }
}
