//! Integrates slopes to heights by a direct least-squares solution of Poisson's equation, for maps of any size.
//!
//! Slopes are seldom integrable, so the heights `h` minimise the distance between their slopes `D h` and the given slopes
//! `s`. Heights that alternate between texels have no texel slope and would be unconstrained. The slope variance of
//! triangles inside a texel therefore gets a small weight:
//!
//! `|D h − s|² + smoothness · (E[|∇h|²] − |E[∇h]|²)`, summed over texels.
//!
//! The mean square of the triangles' slopes equals the mean square of the differences between neighbours
//! ([`moments`](crate::moments)). On a repeating map, or with heights mirrored at the edges, all operators are convolutions
//! that are even along both axes. A transform ([`spectral`](super::spectral)) reduces the solution to a division. Smoothness
//! 0 is the pseudo-inverse of `D`. Smoothness 1 is the finite-element solution, whose normal equation has the five-point
//! Laplacian.

use rayon::prelude::*;

use super::slopes::{Difference, Slopes};
use super::spectral::{Transform, transpose};
use crate::limits::{MAX_HEIGHT, zeroed};
use crate::{HeightMap, MapFault, Wrap};

/// Options for the integration of slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integration {
    /// Whether the map repeats.
    pub wrap: Wrap,
    /// The difference operator that converts the heights back to slopes.
    pub difference: Difference,
    /// The weight of the slope variance inside texels, from 0 to 1. With a lower weight, the heights follow the normals more
    /// closely, up to their curl. A higher weight suppresses two-texel waves, an artefact of 8-bit normals. At weight 1 the
    /// triangles are never rougher than the normals.
    pub smoothness: f64,
}

impl Default for Integration {
    fn default() -> Self {
        Self { wrap: Wrap::Repeat, difference: Difference::Triangles, smoothness: 0.1 }
    }
}

/// Integrated heights, and how well they fit the slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct Integrated {
    /// The heights in texture widths. The mean height is about 0.
    pub heights: HeightMap,
    /// The mean of the given slopes, which repeating heights cannot represent.
    pub mean_slope: [f64; 2],
    /// The RMS of the slopes about their mean.
    pub slope_rms: f64,
    /// The RMS of the curl of the slopes. No heights can represent the curl, so this RMS is the smallest possible error.
    pub curl_rms: f64,
    /// The RMS difference between the given slopes and the slopes of the heights, caused by curl and smoothness.
    pub residual_rms: f64,
}

impl Integrated {
    /// Returns the fraction of the squared slopes about their mean that is curl.
    pub fn curl_share(&self) -> f64 {
        if self.slope_rms > 0.0 { (self.curl_rms / self.slope_rms).powi(2) } else { 0.0 }
    }
}

/// Squared responses of a difference operator below this limit are rounding errors. The longest wave of 65536 texels has a
/// response of 2e-9.
const NO_RESPONSE: f64 = 1e-12;

/// Returns the heights whose slopes are nearest to the given slopes. The computation needs 8 bytes per texel besides the
/// result. Edge texels of non-repeating maps have weight 1/4. `progress` receives the completed fraction, from 0 to 1.
///
/// # Errors
/// Fails if memory runs out.
pub fn heights_of_slopes(slopes: &Slopes, how: &Integration, progress: &dyn Fn(f32)) -> Result<Integrated, MapFault> {
    let (width, height) = (slopes.width as usize, slopes.height as usize);
    let mean = slopes.mean();
    let given =
        Given { slopes, mean: mean.map(|v| v as f32), wrap: how.wrap, difference: how.difference, per_texel: [1.0; 2] };
    let mut image = zeroed::<f32>(width * height)?;
    let mut transposed = zeroed::<f32>(width * height)?;
    let energy = given.divergence(&mut image);
    progress(0.1);
    let along = Transform::new(width, how.wrap);
    let rows = |image: &mut [f32], forward: bool| {
        let pairs = image.par_chunks_mut(2 * width).with_min_len(8);
        pairs.for_each_init(|| along.scratch(), |scratch, rows| along.rows(rows, scratch, forward));
    };
    rows(&mut image, true);
    progress(0.3);
    transpose(&image, width, &mut transposed);
    let [explained, missed] = divide(&mut transposed, [&along, &Transform::new(height, how.wrap)], how);
    progress(0.7);
    transpose(&transposed, height, &mut image);
    drop(transposed);
    rows(&mut image, false);
    progress(0.9);
    let texels = (width * height) as f64;
    let curl = (energy - explained).max(0.0);
    let plane = if how.wrap == Wrap::Clamp { mean } else { [0.0; 2] };
    let (to_widths, limit) = (1.0 / width as f64, f64::from(MAX_HEIGHT));
    image.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let from_middle = |k: usize, of: usize| k as f64 - 0.5 * (of as f64 - 1.0);
        let of_row = plane[1] * from_middle(y, height);
        for (x, texel) in row.iter_mut().enumerate() {
            let whole = f64::from(*texel) + of_row + plane[0] * from_middle(x, width);
            *texel = (to_widths * whole).clamp(-limit, limit) as f32;
        }
    });
    progress(1.0);
    let rms = |sum: f64| (sum / texels).sqrt();
    Ok(Integrated {
        heights: HeightMap::new(slopes.width, slopes.height, image)?,
        mean_slope: mean,
        slope_rms: rms(energy),
        curl_rms: rms(curl),
        residual_rms: rms(curl + missed),
    })
}

/// Divides the transformed `Dᵀ s`, stored by columns, by the operator. Returns the sum of squares of the slopes that heights
/// can represent, and the sum of squares of their residual.
fn divide(columns: &mut [f32], [along, down]: [&Transform; 2], how: &Integration) -> [f64; 2] {
    let smoothness = if how.smoothness.is_nan() { 1.0 } else { how.smoothness.clamp(0.0, 1.0) };
    // The squared responses along each axis of neighbour differences, of central differences, and of the mean over rows.
    let responses = |transform: &Transform| -> Vec<[f64; 3]> {
        let of = |phase: f64| [2.0 - 2.0 * phase.cos(), phase.sin().powi(2), (0.75 + 0.25 * phase.cos()).powi(2)];
        transform.phases().into_iter().map(of).collect()
    };
    let (across, down_by) = (responses(along), responses(down));
    let height = down_by.len();
    let columns = columns.par_chunks_mut(2 * height).enumerate().with_min_len(8);
    let sums: Vec<[f64; 2]> = columns
        .map_init(
            || down.scratch(),
            |scratch, (pair, columns)| {
                down.rows(columns, scratch, true);
                let mut sums = [0.0; 2];
                for (column, a) in columns.chunks_exact_mut(height).zip(&across[2 * pair..]) {
                    for (value, b) in column.iter_mut().zip(&down_by) {
                        let all = a[0] + b[0];
                        let seen = match how.difference {
                            Difference::Triangles => a[1] * b[2] + b[1] * a[2],
                            Difference::Central => a[1] + b[1],
                            Difference::Forward => all,
                        };
                        let by = seen + smoothness * (all - seen);
                        let v = f64::from(*value);
                        if seen > NO_RESPONSE {
                            let square = v * v / seen;
                            sums[0] += square;
                            sums[1] += square * (1.0 - seen / by).powi(2);
                        }
                        *value = if seen > NO_RESPONSE && by > NO_RESPONSE { (v / by) as f32 } else { 0.0 };
                    }
                }
                down.rows(columns, scratch, false);
                sums
            },
        )
        .collect();
    sums.into_iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
}

/// The given slopes minus their mean. Beyond the map, the slopes are differences of mirrored heights.
pub(super) struct Given<'a> {
    pub slopes: &'a Slopes,
    pub mean: [f32; 2],
    pub wrap: Wrap,
    pub difference: Difference,
    /// The factor of each axis, which is the inverse of the texel size.
    pub per_texel: [f32; 2],
}

impl Given<'_> {
    fn of(&self, texel: usize, axis: usize) -> f32 {
        self.per_texel[axis] * (self.slopes.texels[texel][axis] - self.mean[axis])
    }

    /// Returns the slope along an axis (0 is `s`) at a texel, which may lie outside the map. Beyond a non-repeating edge,
    /// the mirrored heights have the opposite slope. At the edge itself the slope is halved, because one neighbour is the
    /// texel itself. Forward differences are 0 there.
    fn at(&self, axis: usize, x: i64, y: i64) -> f32 {
        let size = self.slopes.size();
        let (column, row) = (self.wrap.texel(x, size[0]), self.wrap.texel(y, size[1]));
        let slope = self.of(row * size[0] as usize + column, axis);
        if self.wrap == Wrap::Repeat {
            return slope;
        }
        let (k, last) = ([x, y][axis], i64::from(size[axis]) - 1);
        match self.difference {
            Difference::Forward if k < 0 || k >= last => 0.0,
            Difference::Forward => slope,
            _ if k < 0 || k > last => -0.5 * slope,
            _ if k == 0 || k == last => 0.5 * slope,
            _ => slope,
        }
    }

    /// Returns `Dᵀ s` at a texel. `at` returns the slope for an axis, a column and a row.
    fn transposed(&self, at: impl Fn(usize, i64, i64) -> f32, x: i64, y: i64) -> f32 {
        let across = |y: i64| 0.5 * (at(0, x - 1, y) - at(0, x + 1, y));
        let down = |x: i64| 0.5 * (at(1, x, y - 1) - at(1, x, y + 1));
        match self.difference {
            Difference::Triangles => {
                let beside = across(y - 1) + across(y + 1) + down(x - 1) + down(x + 1);
                0.125 * beside + 0.75 * (across(y) + down(x))
            }
            Difference::Central => across(y) + down(x),
            Difference::Forward => at(0, x - 1, y) - at(0, x, y) + at(1, x, y - 1) - at(1, x, y),
        }
    }

    /// Fills an image with `Dᵀ s` and returns the sum of the squared slopes.
    pub fn divergence(&self, image: &mut [f32]) -> f64 {
        let width = self.slopes.width as usize;
        let rows = image.par_chunks_mut(width).enumerate().with_min_len(8);
        let sums: Vec<f64> = rows
            .map(|(y, row)| {
                let mut sum = 0.0;
                let inside = |k: usize, of: u32| k >= 2 && k + 2 < of as usize;
                let [columns, rows] = self.slopes.size();
                for (x, texel) in row.iter_mut().enumerate() {
                    let inside = inside(x, columns) && inside(y, rows);
                    let (x, y) = (x as i64, y as i64);
                    let edge = |axis, x, y| self.at(axis, x, y);
                    let direct = |axis, x: i64, y: i64| self.of(y as usize * width + x as usize, axis);
                    let squares = |[a, b]: [f32; 2]| f64::from(a).powi(2) + f64::from(b).powi(2);
                    if inside {
                        *texel = self.transposed(direct, x, y);
                        sum += squares([0, 1].map(|axis| direct(axis, x, y)));
                    } else {
                        *texel = self.transposed(edge, x, y);
                        sum += squares([0, 1].map(|axis| edge(axis, x, y)));
                    }
                }
                sum
            })
            .collect();
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::slopes::slopes_of_heights;
    use super::*;

    const ALL: [Difference; 3] = [Difference::Triangles, Difference::Central, Difference::Forward];

    fn noise(width: u32, height: u32) -> HeightMap {
        let texel =
            |i: u32| ((i.wrapping_mul(0x9e37_79b1) ^ 0x51).wrapping_mul(0x85eb_ca6b) >> 8) as f32 / (1 << 24) as f32;
        HeightMap::new(width, height, (0..width * height).map(texel).collect()).unwrap()
    }

    fn solved(slopes: &Slopes, how: Integration) -> Integrated {
        heights_of_slopes(slopes, &how, &|_| {}).unwrap()
    }

    /// Returns the RMS difference of two height maps after subtracting their means, and the RMS of the second map.
    fn apart(a: &HeightMap, b: &HeightMap) -> [f64; 2] {
        let (ma, mb) = (f64::from(a.mean()), f64::from(b.mean()));
        let mut sums = [0.0; 2];
        for (a, b) in a.texels.iter().zip(&b.texels) {
            let (a, b) = (f64::from(*a) - ma, f64::from(*b) - mb);
            sums = [sums[0] + (a - b).powi(2), sums[1] + b * b];
        }
        sums.map(|sum| (sum / a.texels.len() as f64).sqrt())
    }

    #[test]
    fn heights_come_back_from_their_slopes() {
        // With odd sides, central differences lose only the mean, so waves of two texels are recovered too.
        for (width, height) in [(63, 63), (63, 35), (1, 63), (63, 1), (3, 101), (1, 1)] {
            for difference in ALL {
                for wrap in [Wrap::Repeat, Wrap::Clamp] {
                    let heights = noise(width, height);
                    let slopes = slopes_of_heights(&heights, 1.0, wrap, difference);
                    let found = solved(&slopes, Integration { wrap, difference, smoothness: 0.0 });
                    let [error, size] = apart(&found.heights, &heights);
                    assert!(error <= 2e-5 * size, "{width} x {height} {wrap:?} {difference:?}: {error} of {size}");
                    assert!(found.curl_share() < 1e-4 && found.residual_rms <= found.curl_rms * 1.0001, "{found:?}");
                }
            }
        }
    }

    #[test]
    fn even_sides_lose_waves_of_two_texels_alone() {
        let wave = |i: u32| {
            let [s, t] = [i % 64, i / 64].map(|k| TAU * f64::from(k) / 64.0);
            (0.02 * ((3.0 * s).sin() + (30.0 * s + 7.0 * t).cos() + (31.0 * t).sin())) as f32
        };
        let heights = HeightMap::new(64, 64, (0..64 * 64).map(wave).collect()).unwrap();
        for difference in ALL {
            let slopes = slopes_of_heights(&heights, 1.0, Wrap::Repeat, difference);
            let [error, size] = apart(
                &solved(&slopes, Integration { difference, smoothness: 0.0, ..Integration::default() }).heights,
                &heights,
            );
            assert!(error < 1e-5 * size, "{difference:?}: {error} of {size}");
        }
        let checker = HeightMap::new(64, 64, (0..64 * 64).map(|i| ((i % 64 + i / 64) % 2) as f32).collect()).unwrap();
        let slopes = slopes_of_heights(&checker, 1.0, Wrap::Repeat, Difference::Forward);
        let how = Integration { difference: Difference::Forward, ..Integration::default() };
        assert!(apart(&solved(&slopes, how).heights, &checker)[0] < 1e-6);
    }

    #[test]
    fn curl_remains_and_is_reported() {
        // The test field is the sum of a gradient field and a curl field, which are orthogonal to each other.
        let n = 48u32;
        let waves = |i: u32| [i % n, i / n].map(|k| TAU * f64::from(k) / f64::from(n));
        let field = |gradient: f64, curl: f64| {
            let texel = |i: u32| {
                let [s, t] = waves(i);
                let (along_s, along_t) = ((2.0 * s + 3.0 * t).cos() * 2.0, (2.0 * s + 3.0 * t).cos() * 3.0);
                let rotated = [-(5.0 * t).cos(), (4.0 * s).cos()];
                [gradient * along_s + curl * rotated[0] + 0.125, gradient * along_t + curl * rotated[1] - 0.25]
                    .map(|v| v as f32)
            };
            Slopes::new(n, n, (0..n * n).map(texel).collect()).unwrap()
        };
        let how = Integration { smoothness: 0.0, ..Integration::default() };
        let both = solved(&field(0.1, 0.2), how);
        assert!((both.curl_rms - 0.2).abs() < 1e-4, "{both:?}");
        assert!((both.mean_slope[0] - 0.125).abs() < 1e-6 && (both.mean_slope[1] + 0.25).abs() < 1e-6);
        // The wave has direction (2, 3), but the height differences deviate slightly from this direction.
        let gradient = solved(&field(0.1, 0.0), how);
        assert!(gradient.curl_share() < 2e-3, "{gradient:?}");
        let [error, size] = apart(&both.heights, &gradient.heights);
        assert!(error < 1e-5 * size, "{error} of {size}");
        // The reported residual must equal the actual one.
        for smoothness in [0.0, 0.1, 1.0] {
            let how = Integration { smoothness, ..how };
            let slopes = field(0.1, 0.2);
            let found = solved(&slopes, how);
            let again = slopes_of_heights(&found.heights, 1.0, how.wrap, how.difference);
            let mean = slopes.mean();
            let square = |(a, b): (&[f32; 2], &[f32; 2])| -> f64 {
                (0..2).map(|i| (f64::from(a[i]) - mean[i] - f64::from(b[i])).powi(2)).sum()
            };
            let left: f64 = slopes.texels().iter().zip(again.texels()).map(square).sum();
            let left = (left / f64::from(n * n)).sqrt();
            assert!((left - found.residual_rms).abs() < 1e-4 * left, "{smoothness}: {left} {found:?}");
        }
    }

    #[test]
    fn non_repeating_plane_is_recovered() {
        let slopes = Slopes::new(40, 20, vec![[0.5, -2.0]; 800]).unwrap();
        let how = Integration { wrap: Wrap::Clamp, ..Integration::default() };
        let found = solved(&slopes, how);
        assert!((found.heights.at(39, 3) - found.heights.at(0, 3) - 0.5 * 39.0 / 40.0).abs() < 1e-5);
        assert!((found.heights.at(5, 19) - found.heights.at(5, 0) + 2.0 * 19.0 / 40.0).abs() < 1e-5);
        let found = solved(&slopes, Integration::default());
        assert!(found.heights.texels.iter().all(|h| h.abs() < 1e-5) && found.mean_slope == [0.5, -2.0]);
    }

    #[test]
    fn the_steepest_slopes_stay_finite() {
        let sign = |i: usize| if i.is_multiple_of(3) { 1e6 } else { -1e6 };
        let slopes = Slopes::new(50, 30, (0..1500).map(|i| [sign(i), sign(i / 7)]).collect()).unwrap();
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            for difference in ALL {
                for smoothness in [0.0, f64::NAN, 9.0] {
                    let found = solved(&slopes, Integration { wrap, difference, smoothness });
                    assert!(
                        found.heights.texels.iter().all(|h| h.is_finite()) && found.residual_rms.is_finite(),
                        "{wrap:?} {difference:?} {smoothness}"
                    );
                }
            }
        }
    }
}
