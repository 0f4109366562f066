//! Converts slopes to heights by relaxation, coarse levels first (Chan 2018, section 4.2 and algorithm 5).
//!
//! Each texel takes the mean of the heights that its four neighbours and the steps between them give. This is a Gauss–Seidel step for the
//! five-point Laplacian, which is the normal equation of [`heights_of_slopes`](leadr_maps::derive::heights_of_slopes) at smoothness 1.
//!
//! The module differs from the printed algorithm in four points:
//! * `D_y` is `−n.y / n.z`. The copy at hand has `−n.x / n.z`.
//! * `R` and `D` subtract the step, because the neighbour to the right or below is higher by the step.
//! * The steps between the texels of a half-size level are twice as large.
//! * Texels change in place, in the order of a chessboard. The text visits texels in random order. The listing writes all new heights at
//!   once, which does not reduce waves of two texels.

use leadr_maps::derive::{Difference, Slopes};
use leadr_maps::{HeightMap, MapFault};

/// The slopes of a repeating level, as rise per texel of the level.
struct Level {
    size: [usize; 2],
    slopes: Vec<[f64; 2]>,
}

impl Level {
    fn index(&self, x: usize, y: usize) -> usize {
        y % self.size[1] * self.size[0] + x % self.size[0]
    }

    /// Returns the level of half the size, or `None` if a side is odd.
    fn half(&self) -> Option<Self> {
        if self.size.iter().any(|side| side % 2 == 1) {
            return None;
        }
        let size = self.size.map(|side| side / 2);
        let texel = |i: usize| {
            let (x, y) = (i % size[0] * 2, i / size[0] * 2);
            let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| self.slopes[self.index(x, y)]);
            // The mean of four slopes, over texels of twice the size.
            [0, 1].map(|axis| 0.5 * four.iter().map(|slope| slope[axis]).sum::<f64>())
        };
        Some(Self { size, slopes: (0..size[0] * size[1]).map(texel).collect() })
    }

    /// Returns the steps from each texel to its right and its lower neighbour, such that the heights without error are those of
    /// `difference` at smoothness 1.
    fn steps(&self, difference: Difference) -> Vec<[f64; 2]> {
        let [width, height] = self.size;
        let beside: &[(usize, f64)] = match difference {
            Difference::Triangles => &[(0, 0.75), (1, 0.125), (usize::MAX, 0.125)],
            Difference::Central | Difference::Forward => &[(0, 1.0)],
        };
        let ahead: &[(usize, f64)] = match difference {
            Difference::Forward => &[(0, 1.0)],
            Difference::Triangles | Difference::Central => &[(0, 0.5), (1, 0.5)],
        };
        let moved = |k: usize, by: usize, side: usize| if by == usize::MAX { k + side - 1 } else { k + by };
        let step = |i: usize, axis: usize| {
            let (x, y) = (i % width, i / width);
            let mut sum = 0.0;
            for (across, weight) in beside {
                for (along, share) in ahead {
                    let by = if axis == 0 { [*along, *across] } else { [*across, *along] };
                    sum +=
                        weight * share * self.slopes[self.index(moved(x, by[0], width), moved(y, by[1], height))][axis];
                }
            }
            sum
        };
        (0..width * height).map(|i| [step(i, 0), step(i, 1)]).collect()
    }

    /// Returns heights of half the size, interpolated bilinearly to this level.
    fn enlarged(&self, coarse: &[f64]) -> Vec<f64> {
        let [width, height] = self.size.map(|side| side / 2);
        // The nearer of two coarse texels has weight 3/4.
        let taps = |k: usize, side: usize| {
            [(k / 2, 0.75), ((k / 2 + if k.is_multiple_of(2) { side - 1 } else { 1 }) % side, 0.25)]
        };
        let texel = |i: usize| {
            let (columns, rows) = (taps(i % self.size[0], width), taps(i / self.size[0], height));
            let row = |y: usize| columns.iter().map(|(x, weight)| weight * coarse[y * width + x]).sum::<f64>();
            rows.iter().map(|(y, weight)| weight * row(*y)).sum()
        };
        (0..self.slopes.len()).map(texel).collect()
    }

    fn heights(&self, difference: Difference, sweeps: u32) -> Vec<f64> {
        let [width, height] = self.size;
        let coarse = self.half().map(|half| half.heights(difference, sweeps));
        let mut heights = coarse.map_or_else(|| vec![0.0; width * height], |coarse| self.enlarged(&coarse));
        let steps = self.steps(difference);
        for colour in (0..sweeps).flat_map(|_| [0, 1]) {
            for y in 0..height {
                for x in ((y + colour) % 2..width).step_by(2) {
                    let (left, up) = (self.index(x + width - 1, y), self.index(x, y + height - 1));
                    let (right, down) = (self.index(x + 1, y), self.index(x, y + 1));
                    let here = self.index(x, y);
                    let before = heights[left] + steps[left][0] + heights[up] + steps[up][1];
                    heights[here] = 0.25 * (before + heights[right] - steps[here][0] + heights[down] - steps[here][1]);
                }
            }
        }
        heights
    }
}

/// Returns the heights of a repeating map in texture widths, after `sweeps` visits to every texel of each level. The mean height is 0.
///
/// # Errors
/// Fails if a height is beyond the limit of maps.
pub fn relaxed_heights(slopes: &Slopes, difference: Difference, sweeps: u32) -> Result<HeightMap, MapFault> {
    let [width, height] = slopes.size();
    let texels = slopes.texels().iter().map(|slope| slope.map(f64::from)).collect();
    let level = Level { size: [width, height].map(|side| side as usize), slopes: texels };
    let heights = level.heights(difference, sweeps);
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    HeightMap::new(width, height, heights.iter().map(|h| ((h - mean) / f64::from(width)) as f32).collect())
}

/// Returns the RMS difference of two height maps about their means, relative to the RMS of the second.
pub fn relative_difference(a: &HeightMap, b: &HeightMap) -> f64 {
    let (mean_a, mean_b) = (f64::from(a.mean()), f64::from(b.mean()));
    let sums = a.texels.iter().zip(&b.texels).fold([0.0; 2], |sums, (a, b)| {
        let (a, b) = (f64::from(*a) - mean_a, f64::from(*b) - mean_b);
        [sums[0] + (a - b).powi(2), sums[1] + b * b]
    });
    (sums[0] / sums[1].max(f64::MIN_POSITIVE)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::derive::{Integration, heights_of_slopes, slopes_of_heights};
    use leadr_maps::{Wrap, procedural};

    fn direct(slopes: &Slopes, difference: Difference) -> HeightMap {
        let how = Integration { wrap: Wrap::Repeat, difference, smoothness: 1.0 };
        heights_of_slopes(slopes, &how, &|_| ()).unwrap().heights
    }

    /// With many sweeps, the heights are those of the direct solution. A side of 24 ends at an odd level of 3 texels.
    #[test]
    fn relaxation_solves_the_same_equation() {
        let map = procedural::gaussian(24, 24, 7, 0.5, 0.15);
        for difference in [Difference::Triangles, Difference::Central, Difference::Forward] {
            let slopes = slopes_of_heights(&map, 1.0, Wrap::Repeat, difference);
            let relaxed = relaxed_heights(&slopes, difference, 2000).unwrap();
            let error = relative_difference(&relaxed, &direct(&slopes, difference));
            println!("{difference:?}: {error:.1e}");
            assert!(error < 1e-6, "{difference:?}: {error}");
        }
    }

    /// Few sweeps of each level leave a large part of the error.
    #[test]
    fn relaxation_converges_slowly() {
        let map = procedural::gaussian(128, 128, 7, 0.5, 0.05);
        let slopes = slopes_of_heights(&map, 1.0, Wrap::Repeat, Difference::Triangles);
        let direct = direct(&slopes, Difference::Triangles);
        let errors = [3, 10, 100].map(|sweeps| {
            relative_difference(&relaxed_heights(&slopes, Difference::Triangles, sweeps).unwrap(), &direct)
        });
        println!("relative difference after 3, 10 and 100 sweeps: {errors:.4?}");
        assert!(errors[0] > 0.1 && errors[1] < 0.1 && errors[2] < 0.01, "{errors:?}");
    }
}
