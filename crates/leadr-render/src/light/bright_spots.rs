//! The bright spots of a panorama, and the maxima of the density of these spots.

use glam::DVec3;

use super::texels::{Texels, texel_luminance};
use leadr_maps::RgbImage;

/// The maximum number of texel blocks around the horizon. Each bright spot is one block.
const BLOCKS: usize = 1024;
/// The number of bands into which the sphere is divided. Each band is divided into cells, where the search for maxima starts.
const BANDS: usize = 60;
const MOST_MAXIMA: usize = 48;
/// The maximum number of mean-shift steps towards a maximum. The steps shrink geometrically.
const STEPS: usize = 200;

/// Rises smoothly from 0 at x ≤ 0 to 1 at x ≥ 1.
pub fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Falls smoothly from 1 at x ≤ `from` to 0 at x ≥ `to`.
pub fn falloff(x: f64, [from, to]: [f64; 2]) -> f64 {
    1.0 - smooth((x - from) / (to - from))
}

/// Angles from a maximum in degrees. A direction is fully inside the maximum up to the first angle, and outside from the second
/// angle.
const INSIDE: [f64; 2] = [7.0, 12.0];
/// Angles from a maximum in degrees. Light outside the maximum counts fully as background up to the first angle, and not at all
/// from the second angle.
const AROUND: [f64; 2] = [18.0, 25.0];
/// The standard deviation of the density kernel in degrees. Two spots closer than twice this angle share a maximum, and are fully
/// inside it. Spots further apart lie outside each other's maximum.
const DEVIATION: f64 = 5.0;
/// The radius in radians of the area that is inside a maximum.
pub const REACH: f64 = INSIDE[1].to_radians();
/// The radius in radians of the background around a maximum.
pub const FAR: f64 = AROUND[1].to_radians();

/// Returns the angle between two unit vectors in degrees. The result is accurate for small angles.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * a.distance(b)).min(1.0).asin().to_degrees()
}

/// Returns how far a direction is inside a maximum, from 0 (outside) to 1 (fully inside).
pub fn inside(middle: DVec3, direction: DVec3) -> f64 {
    falloff(angle(middle, direction), INSIDE)
}

/// Returns the weight, from 0 to 1, of a direction in the background estimate around a maximum.
pub fn around(middle: DVec3, direction: DVec3) -> f64 {
    let near = falloff(angle(middle, direction), AROUND);
    if near > 0.0 { near * (1.0 - inside(middle, direction)) } else { 0.0 }
}

fn density(middle: DVec3, direction: DVec3) -> f64 {
    let x = (middle - direction).length_squared() / DEVIATION.to_radians().powi(2);
    if x > 30.0 { 0.0 } else { (-0.5 * x).exp() }
}

/// A bright spot.
pub struct Spot {
    /// The unit direction of the spot.
    pub direction: DVec3,
    /// The luminance above the threshold, times the solid angle.
    pub flux: f64,
}

/// All bright spots of a panorama.
pub struct Spots {
    /// The spots, in image order.
    pub spots: Vec<Spot>,
    cells: Vec<usize>,
    cell_count: usize,
}

impl Spots {
    /// Finds the spots whose luminance is above the threshold.
    pub fn above(image: &RgbImage, sphere: &Texels, threshold: f64) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let block = width.div_ceil(BLOCKS).max(1);
        let mut spots = Vec::new();
        let mut sums = vec![DVec3::ZERO; width.div_ceil(block)];
        let mut fluxes = vec![0.0; sums.len()];
        for top in (0..height).step_by(block) {
            sums.fill(DVec3::ZERO);
            fluxes.fill(0.0);
            for row in top..(top + block).min(height) {
                for (column, &texel) in image.texels[row * width..][..width].iter().enumerate() {
                    let excess = texel_luminance(texel) - threshold;
                    if excess > 0.0 {
                        let flux = excess * sphere.solid_angles[row];
                        fluxes[column / block] += flux;
                        sums[column / block] += flux * sphere.direction(row, column);
                    }
                }
            }
            let found = sums.iter().zip(&fluxes).filter(|(_, flux)| **flux > 0.0);
            spots.extend(found.map(|(sum, &flux)| Spot { direction: sum.normalize_or(DVec3::Z), flux }));
        }
        let mut numbers = std::collections::BTreeMap::new();
        let cells: Vec<usize> = spots
            .iter()
            .map(|spot| {
                let next = numbers.len();
                *numbers.entry(cell_of(spot.direction)).or_insert(next)
            })
            .collect();
        Self { spots, cells, cell_count: numbers.len() }
    }

    /// Returns the maxima of the spots' density. After each maximum is found, its spots are removed before the next search. The
    /// search stops at a maximum with less than `least` flux around it.
    pub fn maxima(&self, least: f64) -> Vec<DVec3> {
        let mut flux: Vec<f64> = self.spots.iter().map(|spot| spot.flux).collect();
        let mut maxima = Vec::new();
        while maxima.len() < MOST_MAXIMA {
            let mut sums = vec![(DVec3::ZERO, 0.0); self.cell_count];
            for ((spot, &cell), &flux) in self.spots.iter().zip(&self.cells).zip(&flux) {
                sums[cell].0 += flux * spot.direction;
                sums[cell].1 += flux;
            }
            let starts: Vec<(DVec3, f64)> =
                sums.into_iter().filter(|s| s.1 > 0.0).map(|(sum, flux)| (sum.normalize_or(DVec3::Z), flux)).collect();
            let flux_about = |at: DVec3| starts.iter().map(|&(d, flux)| flux * density(at, d)).sum::<f64>();
            let candidates = starts.iter().map(|&(at, _)| (at, flux_about(at)));
            let Some((start, _)) = candidates.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            let middle = self.climb(start, &flux);
            let mut taken = 0.0;
            for (spot, flux) in self.spots.iter().zip(&mut flux) {
                let weight = inside(middle, spot.direction);
                taken += weight * *flux;
                *flux *= 1.0 - weight;
            }
            if taken < least {
                break;
            }
            maxima.push(middle);
        }
        maxima
    }

    /// Returns the density maximum that the mean shift reaches from a start direction.
    fn climb(&self, from: DVec3, flux: &[f64]) -> DVec3 {
        let mut at = from;
        for _ in 0..STEPS {
            let pull = |(spot, &flux): (&Spot, &f64)| flux * density(at, spot.direction) * spot.direction;
            let next = self.spots.iter().zip(flux).map(pull).sum::<DVec3>().normalize_or(at);
            let moved = next.distance(at);
            at = next;
            if moved < 1e-9 {
                break;
            }
        }
        at
    }
}

/// Returns the index of the cell that contains a direction. Cells have about equal areas.
fn cell_of(direction: DVec3) -> usize {
    let from_top = direction.truncate().length().atan2(direction.z) / std::f64::consts::PI;
    let band = ((from_top * BANDS as f64) as usize).min(BANDS - 1);
    let around = ((2 * BANDS) as f64 * (std::f64::consts::PI * (band as f64 + 0.5) / BANDS as f64).sin()).ceil();
    let turn = direction.y.atan2(direction.x) / (2.0 * std::f64::consts::PI) + 0.5;
    2 * BANDS * band + ((turn * around) as usize).min(2 * BANDS - 1)
}
