//! Splits a panorama into an image and directional lights. A directional light represents a small, bright region better, because it
//! casts shadows and is not missed by a few probes or nine harmonics. The extracted light is subtracted from the texels.
//!
//! All criteria are continuous, so similar images give similar lights. A region is weighted by its light above the threshold. A
//! region becomes a light to the degree that it is small, round, isolated, strong, and brighter than the first region beyond the
//! maximum number. The remaining light stays in the image.

use std::f64::consts::PI;

use glam::{DMat2, DVec2, DVec3, Vec3};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use super::bright_spots::{self, FAR, REACH, Spots, falloff, smooth};
use super::texels::{Texels, texel_luminance};
use leadr_maps::RgbImage;
use leadr_reflectance::color::luminance;

/// The maximum number of lights that are extracted from a panorama.
pub const MAX_ENVIRONMENT_LIGHTS: u32 = crate::constants::MAX_ENVIRONMENT_LIGHTS as u32;

/// A directional light that was extracted from a panorama.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// The unit direction towards the centre of the light, in world space.
    pub direction: Vec3,
    /// The irradiance on a plane that faces the light, as linear rgb.
    pub irradiance: Vec3,
    /// The variance of the light's directions in radians², along each of the two axes perpendicular to `direction`.
    pub variance: f32,
}

impl EnvironmentLight {
    /// Returns the angular radius in radians of a uniform disk with the same variance.
    pub fn radius(&self) -> f32 {
        2.0 * self.variance.max(0.0).sqrt()
    }

    /// Returns the angular radius in degrees of a uniform disk with the same variance.
    pub fn radius_degrees(&self) -> f32 {
        self.radius().to_degrees()
    }

    /// Maps a point of the unit square to a direction. The directions are uniform on a disk with the light's variance.
    pub fn direction_within(&self, u: [f32; 2]) -> Vec3 {
        let radius = self.radius() * u[0].sqrt();
        let (sine, cosine) = (std::f32::consts::TAU * u[1]).sin_cos();
        let (x, y) = self.direction.any_orthonormal_pair();
        let across = (x * cosine + y * sine) * radius.sin();
        self.direction * radius.cos() + across
    }
}

impl Serialize for EnvironmentLight {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut light = serializer.serialize_struct("EnvironmentLight", 3)?;
        light.serialize_field("direction", &self.direction.to_array())?;
        light.serialize_field("irradiance", &self.irradiance.to_array())?;
        light.serialize_field("radius_degrees", &self.radius_degrees())?;
        light.end()
    }
}

/// The parameters of the light extraction, which are serialised under the names of the command line flags.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LightExtraction {
    /// The maximum number of lights, from 0 to 4. With 0, all light stays in the image.
    #[serde(rename = "environment_lights")]
    pub count: u32,
    /// The lowest radiance of a light, as a multiple of the panorama's mean radiance. The multiple is above 0.
    #[serde(rename = "environment_light_threshold")]
    pub threshold: f32,
}

impl Default for LightExtraction {
    /// Extracts up to four lights with at least eight times the mean radiance.
    fn default() -> Self {
        Self { count: MAX_ENVIRONMENT_LIGHTS, threshold: 8.0 }
    }
}

/// A panorama split into lights and a remaining image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    /// The lights, brightest first.
    pub lights: Vec<EnvironmentLight>,
    /// The index and the remaining radiance of each texel that the extraction darkens, by ascending index.
    pub rest: Vec<(usize, [f32; 3])>,
}

/// The angular spreads of a light in degrees: the standard deviation per axis, times √2. A light counts as small up to the first value,
/// and as large from the second.
const SIZE: [f64; 2] = [3.5, 6.0];
/// Differences in spread between the two axes of a light, also in degrees. A light counts as round up to the first value, and as
/// elongated from the second.
const LENGTH: [f64; 2] = [2.5, 4.0];
/// Ratios of the bright flux around a light to the light's own flux. A light is isolated up to the first value, and belongs to a
/// larger region from the second.
const SURROUNDINGS: [f64; 2] = [0.1, 0.5];
/// Ratios of a light's irradiance to that of a uniform environment with the panorama's mean radiance. A light is ignored up to the
/// first value, and counts fully from the second.
const WORTH: [f64; 2] = [0.01, 0.04];
/// A light counts fully if it is brighter than the first excluded light by this fraction of its own brightness.
const AHEAD: f64 = 0.5;

/// The smallest extracted fraction of a light, which avoids shadow maps for negligible lights.
const LEAST_DEGREE: f64 = 0.02;

/// A region that may become a light.
struct Candidate {
    middle: DVec3,
    flux: f64,
    /// The fraction of the region's light that is extracted, from 0 to 1.
    degree: f64,
}

/// Extracts lights from an equirectangular panorama, in the layout of [`Environment::from_equirect`]. The lights and the remaining
/// image together keep the power of the panorama. The result is deterministic.
///
/// [`Environment::from_equirect`]: super::environment::Environment::from_equirect
pub fn split(image: &RgbImage, how: LightExtraction) -> Split {
    let count = how.count.min(MAX_ENVIRONMENT_LIGHTS) as usize;
    let sphere = Texels::new(image);
    let mean = sphere.integral(image, |_| 1.0) / (4.0 * PI);
    // The comparisons are written so that NaN fails them.
    if count == 0 || !(mean > 0.0 && mean.is_finite() && how.threshold > 0.0) {
        return Split::default();
    }
    let threshold = f64::from(how.threshold) * mean;
    let spots = Spots::above(image, &sphere, threshold);
    let mut candidates: Vec<Candidate> = spots
        .maxima(WORTH[0] * PI * mean)
        .into_iter()
        .map(|direction| candidate(&spots, direction, PI * mean))
        .collect();
    candidates.sort_by(|a, b| (b.degree * b.flux).total_cmp(&(a.degree * a.flux)));
    let left_over = candidates.get(count).map_or(0.0, |next| next.degree * next.flux);
    candidates.truncate(count);
    candidates.retain_mut(|c| {
        let brightness = c.degree * c.flux;
        let ahead = smooth((brightness - left_over) / (AHEAD * brightness).max(1e-300));
        c.degree = (c.degree * ahead - LEAST_DEGREE) / (1.0 - LEAST_DEGREE);
        c.degree > 0.0
    });
    if candidates.is_empty() { Split::default() } else { take(image, &sphere, threshold, &candidates) }
}

/// Returns the candidate around a density maximum. `even` is the irradiance of a uniform environment with the panorama's mean
/// luminance.
fn candidate(spots: &Spots, middle: DVec3, even: f64) -> Candidate {
    let (x, y) = middle.any_orthonormal_pair();
    let (mut flux, mut around, mut first, mut second) = (0.0, 0.0, DVec2::ZERO, [0.0; 3]);
    for spot in &spots.spots {
        let inside = bright_spots::inside(middle, spot.direction);
        let at = DVec2::new(spot.direction.dot(x), spot.direction.dot(y));
        let weight = inside * spot.flux;
        flux += weight;
        around += bright_spots::around(middle, spot.direction) * spot.flux;
        first += weight * at;
        for (sum, product) in second.iter_mut().zip([at.x * at.x, at.y * at.y, at.x * at.y]) {
            *sum += weight * product;
        }
    }
    let per = 1.0 / flux.max(1e-300);
    let mean = first * per;
    let (xx, yy, xy) =
        (second[0] * per - mean.x * mean.x, second[1] * per - mean.y * mean.y, second[2] * per - mean.x * mean.y);
    let half = 0.5 * (xx + yy);
    let apart = (half * half - DMat2::from_cols_array(&[xx, xy, xy, yy]).determinant()).max(0.0).sqrt();
    let degrees = |variance: f64| (2.0 * variance.max(0.0)).sqrt().to_degrees();
    let degree = falloff(degrees(half + apart), SIZE)
        * falloff(degrees(2.0 * apart), LENGTH)
        * falloff(around * per, SURROUNDINGS)
        * (1.0 - falloff(flux / even, WORTH));
    Candidate { middle, flux, degree }
}

/// Subtracts the candidates from every texel above the threshold. The background radiance around each candidate remains.
fn take(image: &RgbImage, sphere: &Texels, threshold: f64, candidates: &[Candidate]) -> Split {
    let bases: Vec<f64> = candidates.iter().map(|c| surroundings(image, sphere, threshold, c.middle)).collect();
    let mut sums = vec![Sum::default(); candidates.len()];
    let mut rest = Vec::new();
    let mut shares = vec![0.0; candidates.len()];
    let lowest = REACH.cos();
    for row in 0..image.height as usize {
        if !candidates.iter().any(|c| sphere.row_meets(row, c.middle, REACH)) {
            continue;
        }
        for column in 0..image.width as usize {
            let index = row * image.width as usize + column;
            let texel = image.texels[index];
            let l = texel_luminance(texel);
            if l <= threshold {
                continue;
            }
            let direction = sphere.direction(row, column);
            if candidates.iter().all(|c| c.middle.dot(direction) <= lowest) {
                continue;
            }
            // A texel just above the threshold keeps all its light. A texel far above it keeps only the background radiance.
            let mut whole = 0.0;
            for ((share, c), base) in shares.iter_mut().zip(candidates).zip(&bases) {
                let kept = base + (threshold - base) * (threshold / l);
                let inside = c.degree * bright_spots::inside(c.middle, direction);
                whole += inside;
                *share = inside * (1.0 - kept / l);
            }
            let scale = 1.0 / whole.max(1.0);
            let taken = shares.iter().sum::<f64>() * scale;
            if taken <= 0.0 {
                continue;
            }
            let left = texel.map(|v| (f64::from(v) * (1.0 - taken)) as f32);
            // The extracted light is exactly the light removed from the image.
            let missing: [f64; 3] = std::array::from_fn(|c| f64::from(texel[c]) - f64::from(left[c]));
            for (sum, share) in sums.iter_mut().zip(&shares) {
                sum.add(missing, direction, share * scale / taken, sphere.solid_angles[row]);
            }
            rest.push((index, left));
        }
    }
    let mut lights: Vec<EnvironmentLight> = sums.iter().filter_map(Sum::light).collect();
    lights.sort_by(|a, b| b.irradiance.element_sum().total_cmp(&a.irradiance.element_sum()));
    Split { lights, rest }
}

/// Returns the mean radiance around a light, clamped to the threshold.
fn surroundings(image: &RgbImage, sphere: &Texels, threshold: f64, middle: DVec3) -> f64 {
    let step = (image.width as usize).div_ceil(2048).max(1);
    let (mut sum, mut weights) = (0.0, 1e-300);
    for row in (0..image.height as usize).step_by(step).filter(|&row| sphere.row_meets(row, middle, FAR)) {
        for column in (0..image.width as usize).step_by(step) {
            let weight = bright_spots::around(middle, sphere.direction(row, column)) * sphere.solid_angles[row];
            if weight > 0.0 {
                sum += weight * texel_luminance(image.texels[row * image.width as usize + column]).min(threshold);
                weights += weight;
            }
        }
    }
    (sum / weights).min(threshold)
}

/// Sums over the texels from which one light is extracted.
#[derive(Clone, Default)]
struct Sum {
    irradiance: DVec3,
    direction: DVec3,
    flux: f64,
    /// The sum over the texels of the variance within a texel times its flux.
    within: f64,
}

impl Sum {
    fn add(&mut self, radiance: [f64; 3], direction: DVec3, share: f64, solid_angle: f64) {
        let power = DVec3::from(radiance) * (share * solid_angle);
        let flux = luminance(power);
        self.irradiance += power;
        self.direction += flux * direction;
        self.flux += flux;
        self.within += flux * solid_angle / 12.0;
    }

    fn light(&self) -> Option<EnvironmentLight> {
        let length = self.direction.length();
        if length <= 0.0 {
            return None;
        }
        // The mean cosine to the mean direction is 1 minus half the sum of the variances along the two axes.
        let variance = (1.0 - length / self.flux).max(0.0) + self.within / self.flux;
        Some(EnvironmentLight {
            direction: (self.direction / length).as_vec3().normalize(),
            irradiance: self.irradiance.as_vec3(),
            variance: variance as f32,
        })
    }
}
