//! Compares a shot with the truth, over the object and over its interior.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::nan::or_nan;
use super::outside::block_means;
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{MapFault, Rgb8Image, RgbImage};
use leadr_reflectance::color::luminance;
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{bias_over, compare, rrmse_over};

/// The width in pixels of the silhouette, which the interior excludes.
pub const SILHOUETTE: u32 = 2;

/// A rendered picture with its coverage.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The linear radiance.
    pub image: RgbImage,
    /// The fraction of each pixel that objects cover, from 0 to 1.
    pub coverage: Vec<f32>,
    /// The device time in milliseconds of all passes and samples.
    pub milliseconds: f64,
    /// The number of samples per pixel.
    pub samples: u32,
    /// The noise of a truth as relative RMSE in the interior, from the difference of its two halves. The noise is 0 for
    /// other pictures.
    pub noise: f64,
}

impl Shot {
    /// Returns the mean of shots with equal sample counts. Sample counts and times are summed.
    ///
    /// # Errors
    /// Fails if sizes differ, or there is no shot.
    pub fn mean(shots: &[Self]) -> Result<Self, MapFault> {
        let Some(first) = shots.first() else { return Err(MapFault::Empty { width: 0, height: 0 }) };
        let share = 1.0 / shots.len() as f32;
        let (mut texels, mut coverage) = (vec![[0.0f32; 3]; first.image.texels.len()], vec![0.0; first.coverage.len()]);
        for shot in shots {
            if (shot.image.width, shot.image.height) != (first.image.width, first.image.height) {
                return Err(MapFault::SizeMismatch { what: "shots of different sizes cannot be averaged".to_owned() });
            }
            for (sum, texel) in texels.iter_mut().zip(&shot.image.texels) {
                (0..3).for_each(|c| sum[c] += share * texel[c]);
            }
            coverage.iter_mut().zip(&shot.coverage).for_each(|(sum, c)| *sum += share * c);
        }
        Ok(Self {
            image: RgbImage::new(first.image.width, first.image.height, texels)?,
            coverage,
            milliseconds: shots.iter().map(|s| s.milliseconds).sum(),
            samples: shots.iter().map(|s| s.samples).sum(),
            noise: 0.0,
        })
    }

    /// Returns the mean of independent truths of different subjects, with its noise.
    ///
    /// # Errors
    /// Returns the errors of [`mean`](Self::mean).
    pub fn mean_of_truths(truths: &[Self]) -> Result<Self, MapFault> {
        let noise = truths.iter().map(|truth| truth.noise.powi(2)).sum::<f64>().sqrt() / truths.len() as f64;
        Ok(Self { noise, ..Self::mean(truths)? })
    }

    /// Returns the mean of two independent shots of one subject, with its noise.
    ///
    /// # Errors
    /// Fails if sizes differ.
    pub fn mean_of(a: &Self, b: &Self) -> Result<Self, MapFault> {
        let mut mean = Self::mean(&[a.clone(), b.clone()])?;
        // Independent halves differ by √2 times the noise of one half. The mean of the halves has 1/√2 of the noise of one
        // half.
        mean.noise = 0.5 * rrmse_over(&a.image, &b.image, &mean.interior()?)?;
        Ok(mean)
    }

    /// Combines this shot with a shot of more samples.
    ///
    /// # Errors
    /// Fails if sizes differ.
    pub fn joined(&self, more: &Self) -> Result<Self, MapFault> {
        if (more.image.width, more.image.height) != (self.image.width, self.image.height) {
            return Err(MapFault::SizeMismatch { what: "shots of different sizes cannot be joined".to_owned() });
        }
        let samples = self.samples + more.samples;
        let share = more.samples as f32 / samples as f32;
        let mix = |a: f32, b: f32| (b - a).mul_add(share, a);
        let texels = self.image.texels.iter().zip(&more.image.texels);
        let texels = texels.map(|(a, b)| std::array::from_fn(|c| mix(a[c], b[c]))).collect();
        Ok(Self {
            image: RgbImage::new(more.image.width, more.image.height, texels)?,
            coverage: self.coverage.iter().zip(&more.coverage).map(|(&a, &b)| mix(a, b)).collect(),
            milliseconds: self.milliseconds + more.milliseconds,
            samples,
            noise: 0.0,
        })
    }

    /// Reduces blocks of `side × side` pixels to one pixel each.
    ///
    /// # Errors
    /// Fails if the picture is smaller than a block.
    pub fn of_blocks(&self, side: u32) -> Result<Self, MapFault> {
        let covered = self.coverage.iter().map(|&c| [c; 3]).collect();
        let coverage = block_means(&RgbImage::new(self.image.width, self.image.height, covered)?, side)?;
        Ok(Self {
            image: block_means(&self.image, side)?,
            coverage: coverage.texels.iter().map(|t| t[0]).collect(),
            samples: self.samples * side * side,
            // The noise is independent between pixels.
            noise: self.noise / f64::from(side),
            ..*self
        })
    }

    /// Returns the pixels that objects touch.
    ///
    /// # Errors
    /// Does not fail for a rendered picture.
    pub fn object(&self) -> Result<Mask, MapFault> {
        Mask::covered(self.image.width, self.image.height, &self.coverage, 1e-4)
    }

    /// Returns the pixels that objects cover fully and that are at least [`SILHOUETTE`] pixels away from all other pixels.
    ///
    /// # Errors
    /// Does not fail for a rendered picture.
    pub fn interior(&self) -> Result<Mask, MapFault> {
        let filled = Mask::covered(self.image.width, self.image.height, &self.coverage, 0.999)?;
        Ok(filled.eroded(SILHOUETTE))
    }

    /// Computes the mean luminance (Rec. 709) over the pixels of a mask, or 0 if the mask is empty.
    pub fn luminance(&self, mask: &Mask) -> f64 {
        let pixels = self.image.texels.iter().zip(&mask.inside).filter(|&(_, &inside)| inside);
        let sum: f64 = pixels.map(|(t, _)| luminance(Vec3::from(*t).as_dvec3())).sum();
        sum / mask.count().max(1) as f64
    }
}

/// The errors over a set of pixels, or NaN if the set is empty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// The mean FLIP error, from 0 to 1.
    #[serde(deserialize_with = "or_nan")]
    pub flip: f64,
    /// The relative RMSE of the linear radiance.
    #[serde(deserialize_with = "or_nan")]
    pub rrmse: f64,
    /// The relative bias, which is positive where the picture is too bright.
    #[serde(deserialize_with = "or_nan")]
    pub bias: f64,
}

/// How the squared error is distributed over the parts of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anatomy {
    /// The fraction of the object's squared error that lies on its silhouette.
    pub outline: f64,
    /// The fraction of the interior's squared error that lies in the brightest twentieth of the reference's interior.
    pub highlights: f64,
}

/// The differences between a test picture and a reference.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The errors over the pixels that the reference's object touches, without the background.
    pub object: Errors,
    /// The errors over the interior, without the silhouette.
    pub interior: Errors,
    /// The distribution of the squared error.
    pub anatomy: Anatomy,
    /// The noise of the reference ([`Shot::noise`]).
    pub noise: f64,
    /// The FLIP error of every pixel, as colours.
    pub error_image: Rgb8Image,
}

/// Compares `test` with `reference`. Before FLIP, both pictures are scaled by `exposure` and displayed with the filmic
/// curve.
///
/// # Errors
/// Fails if sizes differ, or if a pixel is NaN or infinite. The error gives the position of the pixel.
pub fn judge(reference: &Shot, test: &Shot, exposure: f32) -> Result<Verdict, MapFault> {
    let compared = compare(&reference.image, &test.image, exposure, Tonemap::Filmic)?;
    let errors = |mask: &Mask| -> Result<Errors, MapFault> {
        // Without pixels the result is NaN, because 0 would mean that the picture is correct.
        if mask.count() == 0 {
            return Ok(Errors { flip: f64::NAN, rrmse: f64::NAN, bias: f64::NAN });
        }
        Ok(Errors {
            flip: compared.flip_over(mask),
            rrmse: rrmse_over(&reference.image, &test.image, mask)?,
            bias: bias_over(&reference.image, &test.image, mask)?,
        })
    };
    let (object, interior) = (reference.object()?, reference.interior()?);
    Ok(Verdict {
        object: errors(&object)?,
        interior: errors(&interior)?,
        anatomy: anatomy(&reference.image, &test.image, &object, &interior),
        noise: reference.noise,
        error_image: compared.error_image(),
    })
}

fn anatomy(reference: &RgbImage, test: &RgbImage, object: &Mask, interior: &Mask) -> Anatomy {
    // Returns the squared error and the brightness of every pixel in a mask.
    let pixels = |mask: &Mask| -> Vec<(f64, f64)> {
        let pairs = reference.texels.iter().zip(&test.texels).zip(&mask.inside).filter(|&(_, &inside)| inside);
        pairs
            .map(|((r, t), _)| {
                let squared = r.iter().zip(t).map(|(&r, &t)| (f64::from(r) - f64::from(t)).powi(2)).sum();
                (squared, r.iter().map(|&v| f64::from(v)).sum())
            })
            .collect()
    };
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let total = |pixels: &[(f64, f64)]| pixels.iter().map(|p| p.0).sum::<f64>();
    let (whole, mut inside) = (total(&pixels(object)), pixels(interior));
    let within = total(&inside);
    inside.sort_by(|a, b| b.1.total_cmp(&a.1));
    inside.truncate(inside.len().div_ceil(20));
    Anatomy { outline: share(whole - within, whole).max(0.0), highlights: share(total(&inside), within) }
}

/// Estimates the error of the filter over several reliefs, from the error of the mean picture and the errors of single
/// pictures. A single picture also has random errors, because a pixel covers only a few random bumps and the truth is noisy.
/// Averaging n pictures divides the square of these independent errors by n, so (n mean² − single²) / (n − 1) removes the
/// random errors.
pub fn without_relief_noise(of_mean: f64, of_singles: &[f64]) -> f64 {
    let n = of_singles.len() as f64;
    if n < 2.0 {
        return of_mean;
    }
    let single = of_singles.iter().map(|error| error * error).sum::<f64>() / n;
    ((n * of_mean * of_mean - single) / (n - 1.0)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::random::Random;

    /// Returns a disc on a bright background. The interior and the outline are dimmed by factors.
    fn disc(inside: f32, outline: f32) -> Shot {
        let (mut texels, mut coverage) = (Vec::new(), Vec::new());
        for i in 0..40 * 40 {
            let radius = ((i % 40) as f32 - 19.5).hypot((i / 40) as f32 - 19.5);
            let share = (15.0 - radius).clamp(0.0, 1.0);
            let value = if radius < 12.0 { 0.4 * inside } else { 0.4 * outline };
            texels.push([value * share + 2.0 * (1.0 - share); 3]);
            coverage.push(share);
        }
        Shot { image: RgbImage::new(40, 40, texels).unwrap(), coverage, milliseconds: 1.0, samples: 1, noise: 0.0 }
    }

    #[test]
    fn blocks_have_the_samples_of_their_pixels() {
        let shot = Shot { noise: 0.4, samples: 3, ..disc(1.0, 0.5) };
        let blocks = shot.of_blocks(4).unwrap();
        assert_eq!((blocks.image.width, blocks.image.height, blocks.coverage.len()), (10, 10, 100));
        assert_eq!((blocks.samples, blocks.noise), (48, 0.1));
        assert!((blocks.coverage[55] - 1.0).abs() < 1e-6 && (blocks.image.texels[55][0] - 0.4).abs() < 1e-6);
        let mean = |shot: &Shot| shot.coverage.iter().sum::<f32>() / shot.coverage.len() as f32;
        assert!((mean(&blocks) - mean(&shot)).abs() < 1e-5);
    }

    /// The pictures have a known common error, and independent random errors.
    #[test]
    fn grain_is_separated_from_filter_error() {
        let (bias, grain, n) = (0.03, 0.1, 8);
        let mut random = Random::stream(1, 0);
        let (mut found, mut of_means, rounds) = (0.0, 0.0, 200);
        for _ in 0..rounds {
            let all: Vec<Vec<f64>> =
                (0..n).map(|_| (0..400).map(|_| bias + grain * random.normals()[0]).collect()).collect();
            let rms = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            let mean: Vec<f64> = (0..400).map(|i| all.iter().map(|one| one[i]).sum::<f64>() / n as f64).collect();
            let singles: Vec<f64> = all.iter().map(|one| rms(one)).collect();
            found += without_relief_noise(rms(&mean), &singles).powi(2) / f64::from(rounds);
            of_means += rms(&mean).powi(2) / f64::from(rounds);
        }
        assert!((found.sqrt() - bias).abs() < 0.001, "{}", found.sqrt());
        // The error of the mean alone overestimates the bias.
        assert!(of_means.sqrt() > 1.4 * bias, "{}", of_means.sqrt());
        assert_eq!(without_relief_noise(0.2, &[0.2]), 0.2);
        assert_eq!(without_relief_noise(0.1, &[0.5, 0.5]), 0.0);
    }

    #[test]
    fn half_difference_estimates_noise() {
        let mean = Shot::mean_of(&disc(1.1, 1.0), &disc(0.9, 1.0)).unwrap();
        assert!((mean.noise - 0.1).abs() < 0.01, "{}", mean.noise);
        assert_eq!(mean.samples, 2);
        assert!((mean.image.at(20, 20)[0] - 0.4).abs() < 1e-6);
    }

    #[test]
    fn samples_join_by_their_numbers() {
        let (one, mut three) = (disc(1.0, 1.0), disc(0.2, 1.0));
        three.samples = 3;
        let joined = one.joined(&three).unwrap();
        assert_eq!((joined.samples, joined.milliseconds), (4, 2.0));
        assert!((joined.image.at(20, 20)[0] - 0.4 * (0.25 + 0.75 * 0.2)).abs() < 1e-6);
    }

    #[test]
    fn interior_and_outline_are_separated() {
        let truth = disc(1.0, 1.0);
        let same = judge(&truth, &truth, 1.0).unwrap();
        assert_eq!((same.object.rrmse, same.interior.flip), (0.0, 0.0));
        let dim = judge(&truth, &disc(0.5, 1.0), 1.0).unwrap();
        assert!((dim.interior.bias + 0.5).abs() < 0.05 && dim.interior.rrmse > 0.4, "{:?}", dim.interior);
        let edge = judge(&truth, &disc(1.0, 0.5), 1.0).unwrap();
        assert!(edge.object.rrmse > 5.0 * edge.interior.rrmse, "{:?} {:?}", edge.object, edge.interior);
        assert!(edge.anatomy.outline > 0.9 && dim.anatomy.outline < 0.2, "{:?} {:?}", edge.anatomy, dim.anatomy);
        // Half of the light is missing everywhere, which is not an error of the highlights.
        assert!(dim.anatomy.highlights < 0.1, "{:?}", dim.anatomy);
        let mut lit = truth.clone();
        (790..795).for_each(|i| lit.image.texels[i] = [9.0; 3]);
        assert!(judge(&lit, &truth, 1.0).unwrap().anatomy.highlights > 0.9);
        assert!((truth.luminance(&truth.interior().unwrap()) - 0.4).abs() < 1e-6);
    }
}
