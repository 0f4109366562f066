//! The material of a surface on the device, with the inputs that are filtered in addition to the slopes. Each input has
//! area-weighted mips:
//!
//! * colour, sRGB: the albedo, which is averaged in linear light, and the square root of the roughness `α`, which is averaged as
//!   the variance `α²` (LEADR section 4.1)
//! * reflectance at normal incidence, sRGB
//! * emission, linear, half floats
//! * accessibility, 8 bits, or cones of ambient visibility, four components of 8 bits
//! * clear coat, two images of half floats: weight, `α²` and the moments of the slopes
//! * coverage, 8 bits: a mask, and the covered fraction of each texel. Mips average the fraction, because averages of the mask
//!   would lose or thicken details that are thinner than a texel

use std::borrow::Cow;
use std::sync::Arc;

use half::f16;
use leadr_gpu::vk;
use rayon::prelude::*;

use super::displacement::Border;
use crate::scene::{CoatTexel, Cutout, MaterialMap, PropertyMap};
use leadr_gpu::{AddressMode, Filter, Gpu, GpuError, Image, ImageDesc, Result, Sampler, SpecValue};
use leadr_maps::material::{TextureWrap, alpha_of};
use leadr_maps::moments::coverage;
use leadr_maps::srgb::{linear_of_srgb8, srgb8_from_linear};

/// The format of images of linear half floats.
pub const HALF_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// The format of the albedo and of the reflectance.
const COLOR_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
/// The format of accessibility.
const SHARE_FORMAT: vk::Format = vk::Format::R8_UNORM;
const CONE_FORMAT: vk::Format = vk::Format::R8G8B8A8_SNORM;
const COVERAGE_FORMAT: vk::Format = vk::Format::R8G8_UNORM;

/// The images of a material, with placeholders for missing images. Clones share the images.
#[derive(Clone)]
pub struct MaterialImages {
    /// The albedo, with the square root of `α` in alpha.
    pub color: Image,
    /// The reflectance at normal incidence.
    pub f0: Image,
    /// The emitted radiance, in linear light.
    pub emission: Image,
    /// The accessibility, or cones of ambient visibility.
    pub occlusion: Image,
    /// The mask and the coverage.
    pub opacity: Image,
    /// The clear coat in two images: weight, `α²`, `E[x]`, `E[y]`; `E[x²]`, `E[y²]`, `E[xy]`.
    pub coat: Option<[Image; 2]>,
    /// Four samplers: for images like colours (with reflectance), emission, accessibility, and coverage.
    pub samplers: [Sampler; 4],
    /// The inputs that the material has.
    pub features: MaterialFeatures,
}

/// The inputs of a material, without its colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MaterialFeatures {
    /// Whether the material has reflectance at normal incidence.
    pub f0: bool,
    /// The features that the base has beyond a single lobe.
    pub bases: Bases,
    /// Whether the material has emission.
    pub emission: bool,
    /// Whether the material has accessibility or cones.
    pub occlusion: bool,
    /// The alpha mask or the partial coverage, or `None` for an opaque surface.
    pub cutout: Option<CutoutKind>,
    /// Whether the material has a map of a clear coat.
    pub coat: bool,
}

/// The features of surfaces beyond a base with a single lobe. Each combination has its own pipelines, so absent features cost
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Bases {
    /// The maximum number of lobes of a measured material, or 0 without measured materials.
    pub fit_lobes: u32,
    /// Whether all surfaces use measured materials.
    pub all_fitted: bool,
    /// Whether ambient visibility is stored as cones.
    pub cones: bool,
    /// The maximum number of classes of facets, where 0 counts as one.
    pub classes: u32,
    /// Whether there is a clear coat.
    pub coat: bool,
    /// Whether light passes through the surface.
    pub transmits: bool,
}

impl Bases {
    /// Returns the features that two sets of surfaces have together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            fit_lobes: self.fit_lobes.max(other.fit_lobes),
            all_fitted: self.all_fitted && other.all_fitted,
            cones: self.cones || other.cones,
            classes: self.classes.max(other.classes),
            coat: self.coat || other.coat,
            transmits: self.transmits || other.transmits,
        }
    }

    /// Returns these features, reduced to the features that `other` also has.
    #[must_use]
    pub fn within(self, other: Self) -> Self {
        Self {
            fit_lobes: self.fit_lobes.min(other.fit_lobes),
            all_fitted: self.all_fitted || other.all_fitted,
            cones: self.cones && other.cones,
            classes: self.classes.min(other.classes),
            coat: self.coat && other.coat,
            transmits: self.transmits && other.transmits,
        }
    }

    /// Returns the specialisation constants of `passes/bases.glsl`.
    pub fn spec(self) -> [(&'static str, SpecValue); 6] {
        [
            ("FIT_LOBES", SpecValue::I32(self.fit_lobes as i32)),
            // The coat itself is not measured.
            ("ALL_FITTED", SpecValue::Bool(self.all_fitted && !self.coat)),
            ("CONES", SpecValue::Bool(self.cones)),
            ("CLASSES", SpecValue::I32(self.classes.max(1) as i32)),
            ("COATED", SpecValue::Bool(self.coat)),
            ("TRANSMITS", SpecValue::Bool(self.transmits)),
        ]
    }
}

/// The kind of transparency that a cutout surface has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CutoutKind {
    /// The surface has an alpha mask, [`Cutout::Mask`].
    Mask,
    /// The surface has partial coverage, [`Cutout::Share`].
    Share,
}

impl MaterialFeatures {
    /// Returns the inputs that `map` has.
    pub fn of(map: &MaterialMap) -> Self {
        Self {
            f0: map.f0.is_some(),
            bases: Bases {
                fit_lobes: map.fit.as_ref().map_or(0, |fit| fit.lobes()),
                all_fitted: map.fit.is_some(),
                cones: map.cones.is_some(),
                classes: 0,
                coat: false,
                transmits: false,
            },
            emission: map.emission.is_some(),
            occlusion: map.occlusion.is_some() || map.cones.is_some(),
            cutout: map.opacity.as_ref().map(|cutout| match cutout {
                Cutout::Mask(_) => CutoutKind::Mask,
                Cutout::Share(_) => CutoutKind::Share,
            }),
            coat: map.coat.is_some(),
        }
    }
}

impl MaterialImages {
    /// Creates white placeholder images with one texel, for objects without a material.
    pub fn none(gpu: &Arc<Gpu>) -> Result<Self> {
        let none = |what: &str, format| {
            let image = Image::new(gpu, &format!("no {what}"), ImageDesc::new(format, 1, 1))?;
            image.write(0, 0, &vec![u8::MAX; image.texel_bytes()? as usize])?;
            Ok::<_, GpuError>(image)
        };
        let any = Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?;
        Ok(Self {
            color: none("colour", COLOR_FORMAT)?,
            f0: none("reflectance", COLOR_FORMAT)?,
            emission: none("emission", HALF_FORMAT)?,
            occlusion: none("accessibility", SHARE_FORMAT)?,
            opacity: none("coverage", COVERAGE_FORMAT)?,
            coat: None,
            samplers: std::array::from_fn(|_| any.clone()),
            features: MaterialFeatures::default(),
        })
    }

    /// Uploads a material with its mips. In an atlas, the last mip has one texel per tile. `none` holds the placeholders for
    /// missing images.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the reflectance and the colours differ in size.
    pub fn new(gpu: &Arc<Gpu>, name: &str, map: MaterialMap, border: Border, none: &Self) -> Result<Self> {
        let sampler = |wrap: [TextureWrap; 2]| {
            let modes = match border {
                // The colours of surfaces without relief use their own wrap modes, which repeat by default.
                Border::Wrap | Border::Clamp => wrap.map(address_mode),
                Border::Tiles(_) => [AddressMode::ClampToEdge; 2],
            };
            Sampler::with_modes(gpu, Filter::Trilinear, modes)
        };
        let features = MaterialFeatures::of(&map);
        let MaterialMap { width, height, colors, f0, wrap, emission, occlusion, cones, opacity, coat, .. } = map;
        let size = [width, height];
        if f0.as_ref().is_some_and(|f0| f0.len() != colors.len()) {
            let fault = "reflectance and colours differ in size".to_owned();
            return Err(GpuError::Usage { name: format!("material of {name}"), fault });
        }
        let image_of = |what: &str, format, [width, height]: [u32; 2]| {
            let desc = ImageDesc::new(format, width, height).full_mips();
            Image::new(gpu, &format!("{name} {what}"), desc.mips(mips_of(desc, border)))
        };
        let image = |what: &str, format| image_of(what, format, size);
        let plate_wrap = |wrap: Option<[TextureWrap; 2]>| sampler(wrap.unwrap_or_default());
        let samplers = [
            sampler(wrap)?,
            plate_wrap(emission.as_ref().map(|plate| plate.wrap))?,
            plate_wrap(occlusion.as_ref().map(|plate| plate.wrap).or(cones.as_ref().map(|plate| plate.wrap)))?,
            plate_wrap(opacity.as_ref().map(|cutout| cutout.map().wrap))?,
        ];
        let codes = Codes::new();
        let write = |image: &Image, texels| {
            write_mips(
                image,
                size,
                texels,
                |texels| Cow::Borrowed(texels),
                |texels, from, to| codes.halve(texels, from, to),
            )
        };
        let color = image("colour", COLOR_FORMAT)?;
        write(&color, colors)?;
        let f0 = match f0 {
            Some(texels) => {
                let f0 = image("reflectance", COLOR_FORMAT)?;
                write(&f0, texels)?;
                f0
            }
            None => none.f0.clone(),
        };
        let emission = match emission {
            Some(PropertyMap { width, height, texels, .. }) => {
                let emission = image_of("emission", HALF_FORMAT, [width, height])?;
                let texels = texels.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
                write_mips(&emission, [width, height], texels, halves, halve)?;
                emission
            }
            None => none.emission.clone(),
        };
        let occlusion = match (occlusion, cones) {
            (_, Some(PropertyMap { width, height, texels, .. })) => {
                let cones = image_of("cones", CONE_FORMAT, [width, height])?;
                write_mips(&cones, [width, height], texels, signed_eighths, halve)?;
                cones
            }
            (Some(PropertyMap { width, height, texels, .. }), None) => {
                let occlusion = image_of("accessibility", SHARE_FORMAT, [width, height])?;
                write_mips(&occlusion, [width, height], texels, eighths, halve_shares)?;
                occlusion
            }
            (None, None) => none.occlusion.clone(),
        };
        let opacity = match opacity {
            Some(cutout) => {
                let plate = cutout.map();
                let size = [plate.width, plate.height];
                let opacity = image_of("coverage", COVERAGE_FORMAT, size)?;
                let texels = plate.texels.iter().zip(covered(&cutout)).map(|(&mask, share)| [mask, share, 0.0, 0.0]);
                write_mips(&opacity, size, texels.collect(), pairs, halve)?;
                opacity
            }
            None => none.opacity.clone(),
        };
        let coat = match coat {
            Some(plate) => {
                let size = [plate.width, plate.height];
                let layer = |what: &str, texels| {
                    let image = image_of(what, HALF_FORMAT, size)?;
                    write_mips(&image, size, texels, halves, halve)?;
                    Ok::<_, GpuError>(image)
                };
                let [first, second] = coat_texels(&plate.texels);
                Some([layer("clear coat", first)?, layer("slopes of the clear coat", second)?])
            }
            None => None,
        };
        Ok(Self { color, f0, emission, occlusion, opacity, coat, samplers, features })
    }
}

/// Returns the number of mips of an image. In an atlas, the last mip has one texel per tile.
fn mips_of(desc: ImageDesc, border: Border) -> u32 {
    match border {
        Border::Tiles(layout) => layout.tile.ilog2() + 1,
        Border::Wrap | Border::Clamp => desc.mips,
    }
}

/// Returns the coverage of each texel in a form that can be averaged. For a mask, it is the covered fraction of the texel. The
/// finest level is interpolated bilinearly at many positions of the texel.
fn covered(cutout: &Cutout) -> Vec<f32> {
    let PropertyMap { width, height, texels, wrap } = match cutout {
        Cutout::Share(plate) => return plate.texels.clone(),
        Cutout::Mask(plate) => plate,
    };
    const SUBTEXELS: usize = 16;
    let at = |x: i64, y: i64| texels[(wrap[1].texel(y, *height) * width + wrap[0].texel(x, *width)) as usize];
    let texel = |index: usize| {
        let [x, y] = [index as i64 % i64::from(*width), index as i64 / i64::from(*width)];
        let around: [[f32; 3]; 3] =
            std::array::from_fn(|j| std::array::from_fn(|i| at(x + i as i64 - 1, y + j as i64 - 1)));
        let covers = around.as_flattened().iter().filter(|v| **v >= 0.5).count();
        if covers == 0 || covers == 9 {
            return if covers == 0 { 0.0 } else { 1.0 };
        }
        let inside = (0..SUBTEXELS * SUBTEXELS).filter(|k| {
            let [u, v] = [k % SUBTEXELS, k / SUBTEXELS].map(|k| (k as f32 + 0.5) / SUBTEXELS as f32 + 0.5);
            let (i, j) = (u as usize, v as usize);
            let (s, t) = (u - i as f32, v - j as f32);
            let row = |j: usize| around[j][i] + s * (around[j][i + 1] - around[j][i]);
            row(j) + t * (row(j + 1) - row(j)) >= 0.5
        });
        inside.count() as f32 / (SUBTEXELS * SUBTEXELS) as f32
    };
    (0..texels.len()).into_par_iter().map(texel).collect()
}

pub(super) fn address_mode(wrap: TextureWrap) -> AddressMode {
    match wrap {
        TextureWrap::Repeat => AddressMode::Repeat,
        TextureWrap::Mirror => AddressMode::Mirror,
        TextureWrap::Clamp => AddressMode::ClampToEdge,
    }
}

/// Returns the texels of both images of a clear coat, whose values are linear, so that mips average them.
fn coat_texels(texels: &[CoatTexel]) -> [Vec<[f32; 4]>; 2] {
    let first = |texel: &CoatTexel| [texel.weight, texel.alpha * texel.alpha, texel.slope[0], texel.slope[1]];
    let second = |&CoatTexel { slope: [x, y], .. }: &CoatTexel| [x * x, y * y, x * y, 0.0];
    [texels.iter().map(first).collect(), texels.iter().map(second).collect()]
}

/// Encodes fractions from 0 to 1 as unsigned 8-bit integers.
fn eighths(shares: &[f32]) -> Cow<'_, [u8]> {
    shares.iter().map(|share| (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect()
}

/// Encodes numbers from -1 to 1 as signed 8-bit integers.
fn signed_eighths(texels: &[[f32; 4]]) -> Cow<'_, [[i8; 4]]> {
    texels.iter().map(|texel| texel.map(|v| (v.clamp(-1.0, 1.0) * 127.0).round() as i8)).collect()
}

fn pairs(texels: &[[f32; 4]]) -> Cow<'_, [[u8; 2]]> {
    texels.iter().map(|texel| [0, 1].map(|i| (texel[i].clamp(0.0, 1.0) * 255.0 + 0.5) as u8)).collect()
}

fn halve_shares(texels: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    reduce(texels, from, to, |parts| parts.map(|(texel, weight)| weight * texel).sum())
}

pub(super) fn halves(texels: &[[f32; 4]]) -> Cow<'_, [[f16; 4]]> {
    texels.iter().map(|texel| texel.map(|v| f16::from_f32(v.min(65504.0)))).collect()
}

/// Writes `texels` and all coarser levels. `stored` converts texels to the format of the image. `halve` computes the next level
/// from the texels of a level and the sizes of both levels.
pub(super) fn write_mips<T, S: bytemuck::Pod>(
    image: &Image,
    mut size: [u32; 2],
    mut texels: Vec<T>,
    stored: impl for<'a> Fn(&'a [T]) -> Cow<'a, [S]>,
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

/// Computes each texel of the next level as the mean of the texels that it covers. `mean` takes these texels with weights that sum
/// to 1.
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

pub(super) fn halve(texels: &[[f32; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[f32; 4]> {
    reduce(texels, from, to, |parts| {
        parts.fold([0.0; 4], |sum, (texel, weight)| std::array::from_fn(|i| sum[i] + weight * texel[i]))
    })
}

/// Tables that decode colours and roughnesses.
pub(super) struct Codes {
    linear: [f32; 256],
    /// The variance `α²` of each roughness code.
    variance: [f32; 256],
}

impl Codes {
    pub(super) fn new() -> Self {
        let variance = std::array::from_fn(|code| alpha_of(code as u8).powi(2));
        Self { linear: linear_of_srgb8(), variance }
    }

    /// Returns the linear colour and the `α²` of a texel.
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
            // Each texel has exactly four source texels, so no weight tables are needed.
            let mut halved = vec![[0; 4]; to[0] as usize * to[1] as usize];
            let rows = halved.par_chunks_mut(to[0] as usize).zip(texels.par_chunks(2 * width));
            rows.for_each(|(row, two)| {
                let (above, below) = two.split_at(width);
                let pairs = above.as_chunks::<2>().0.iter().zip(below.as_chunks::<2>().0);
                for (texel, (&[a, b], &[c, d])) in row.iter_mut().zip(pairs) {
                    let four = [a, b, c, d].map(|texel| self.linear(texel));
                    *texel = codes(std::array::from_fn(|i| 0.25 * four.iter().map(|texel| texel[i]).sum::<f32>()));
                }
            });
            return halved;
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
    use leadr_maps::material::alpha_code;

    #[test]
    fn mips_average_linear_light_and_variance() {
        let [dark, rough] = [[0, 255, 10, alpha_code(0.0)], [255, 255, 10, alpha_code(0.5)]];
        let half = Codes::new().halve(&[dark, rough, dark, rough], [2, 2], [1, 1]);
        let rough = alpha_of(alpha_code(0.5));
        assert_eq!(half, [[188, 255, 10, alpha_code(rough * 0.5f32.sqrt())]]);
        // An average of the codes would give a much lower roughness.
        assert!(alpha_of(half[0][3]) > 1.3 * alpha_of(alpha_code(0.5) / 2));
    }

    #[test]
    fn odd_rows_and_columns_count() {
        let (black, white) = ([0, 0, 0, 255], [255, 255, 255, 255]);
        let half = Codes::new().halve(&[black, black, white, black, black, white, black, black, white], [3, 3], [1, 1]);
        assert_eq!(half, [[156, 156, 156, 255]]);
        // The code 156 is one third of full brightness in linear light.
        assert!((linear_of_srgb8()[156] - 1.0 / 3.0).abs() < 2e-3);
        let even = halve(&[[1.0; 4], [0.0; 4], [0.0; 4]], [3, 1], [1, 1]);
        assert!((even[0][0] - 1.0 / 3.0).abs() < 1e-6);
    }
}
