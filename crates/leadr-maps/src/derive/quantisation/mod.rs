//! Heights between the codes of a coarse map.
//!
//! Most height maps have 8 bits. If the relief is gentle, the steps between codes are steeper than the relief: a slope of `s`
//! codes per texel with the fraction `f` becomes differences with the mean square `s² + f (1 - f)`. [`restore`] chooses
//! heights within half a code of each code:
//!
//! 1. `smooth` finds the surface with the least bending energy. It is free to bend at edges, where the second difference of
//!    the codes is larger than rounding explains.
//! 2. `roughness` adds the roughness that the codes show and the smoothest surface lacks. It compares the squared
//!    differences of the codes with those that the smoothest surface would have after rounding.

mod roughness;
mod smooth;

use std::fmt;

use rayon::prelude::*;

use crate::{HeightMap, Wrap};

/// The result of [`restore`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation {
    /// The height between two codes, in the unit of the map.
    pub step: f32,
    /// The share of the slope variance of the codes that comes from rounding, from 0 to 1.
    pub before: f64,
    /// The share of the slope variance of the restored heights that the codes do not determine, from 0 to 1. The heights have
    /// this variance because the codes around them are rough.
    pub after: f64,
}

impl fmt::Display for Quantisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [before, after] = [self.before, self.after].map(|share| 100.0 * share);
        let half = 0.5 * self.step;
        write!(
            f,
            "the steps between its codes make {before:.1} % of the slope variance; heights are smoothed within half a code \
             ({half:.5}), and {after:.1} % of their slope variance remain uncertain"
        )
    }
}

/// The height of a step, and the number of steps from 0 to the largest height if the container limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Codes {
    step: f64,
    most: Option<f32>,
}

/// The rounding error of 16-bit codes in 32-bit floats.
const EXACT: f64 = 1e-7;

/// The largest rounding error of finer codes in a 16-bit container, if they were rounded or their bits were repeated.
const ROUNDING: f64 = 1.0 / 65535.0;

/// The relative rounding error of a 16-bit float.
const HALF_FLOAT: f64 = 1.01 / 2048.0;

/// The fewest heights in whole units that are a terrain and not a mask.
const TERRAIN: f64 = 16.0;

impl Codes {
    /// Returns the codes of 8, 10 or 12 bits, or whole numbers, that all heights are.
    fn of(map: &HeightMap) -> Option<Self> {
        // The codes per unit, the largest code, and the absolute and relative error.
        let grids = [
            (255.0, 255.0, ROUNDING, HALF_FLOAT),
            (65535.0 / 256.0, 255.0, EXACT, 0.0),
            (1023.0, 1023.0, ROUNDING, 0.0),
            (65535.0 / 64.0, 1023.0, EXACT, 0.0),
            (4095.0, 4095.0, ROUNDING, 0.0),
            (65535.0 / 16.0, 4095.0, EXACT, 0.0),
        ];
        let is_grid = |&(per_unit, _, absolute, relative): &(f64, f64, f64, f64)| {
            let is_code = |h: f64| (h - (h * per_unit).round() / per_unit).abs() <= absolute + relative * h;
            all(map, |h| (0.0..=1.0 + EXACT).contains(&h) && is_code(h))
        };
        if let Some((per_unit, most, ..)) = grids.into_iter().find(is_grid) {
            return Some(Self { step: 1.0 / per_unit, most: Some(most as f32) });
        }
        let [low, high] = map.texels.iter().fold([f32::MAX, f32::MIN], |[a, b], &h| [a.min(h), b.max(h)]);
        let whole = f64::from(high) - f64::from(low) >= TERRAIN && high.abs().max(low.abs()) < 65536.0;
        (whole && all(map, |h| h.fract() == 0.0)).then_some(Self { step: 1.0, most: None })
    }
}

fn all(map: &HeightMap, holds: impl Fn(f64) -> bool + Sync) -> bool {
    map.texels.par_iter().all(|&h| holds(f64::from(h)))
}

/// Replaces the heights of a coarse map by smooth heights within half a code. Sure edges, clipped areas and rough areas stay.
/// Returns `None` and leaves the map as it is if its heights are not codes of 8, 10 or 12 bits or whole numbers, or if the
/// codes already are the best estimate.
///
/// The heights of JPEG files are treated as 8-bit codes, although their errors are larger where the relief has fine detail.
/// The result does not depend on the number of threads. The working memory is about 40 bytes per texel.
pub fn restore(map: &mut HeightMap, wrap: Wrap) -> Option<Quantisation> {
    let codes = Codes::of(map)?;
    let grid = Grid { width: map.width as usize, height: map.height as usize, wrap };
    let of_texels: Vec<f32> = map.texels.par_iter().map(|&h| (f64::from(h) / codes.step).round() as f32).collect();
    let smooth = smooth::smooth(grid, &of_texels, codes.most);
    let restored = roughness::with_roughness(grid, &of_texels, smooth);
    let [raw, chosen] = [restored.raw, restored.chosen].map(|sum| sum.max(f64::MIN_POSITIVE));
    let found = Quantisation {
        step: codes.step as f32,
        before: (1.0 - chosen / raw).clamp(0.0, 1.0),
        after: ((chosen - restored.smoothest).abs() / chosen).min(1.0),
    };
    let unchanged = restored.heights.par_iter().zip(&of_texels).all(|(h, code)| h == code);
    if unchanged {
        return None;
    }
    map.texels.par_iter_mut().zip(&restored.heights).zip(&of_texels).for_each(|((h, restored), code)| {
        if restored != code {
            *h = (f64::from(*restored) * codes.step) as f32;
        }
    });
    Some(found)
}

/// The size of an image and the rule for texels outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grid {
    width: usize,
    height: usize,
    wrap: Wrap,
}

impl Grid {
    /// Returns the number of texels.
    const fn len(self) -> usize {
        self.width * self.height
    }

    /// Returns the column `dx` beside `x`.
    fn column(self, x: usize, dx: i64) -> usize {
        self.beside(x, dx, self.width)
    }

    /// Returns the index `i + d` on a side of `len` texels. Only indices outside the side need a division.
    fn beside(self, i: usize, d: i64, len: usize) -> usize {
        let index = i as i64 + d;
        if (0..len as i64).contains(&index) { index as usize } else { self.wrap.texel(index, len as u32) }
    }

    /// Returns the texels of the row `dy` below `y`.
    fn row<T>(self, texels: &[T], y: usize, dy: i64) -> &[T] {
        let y = self.beside(y, dy, self.height);
        &texels[y * self.width..(y + 1) * self.width]
    }

    /// Returns the second differences at a texel along x and y. They are 0 across the edge of a map that does not repeat.
    fn second_differences(self, texels: &[f32], x: usize, y: usize) -> [f32; 2] {
        let here = self.row(texels, y, 0);
        let along_x = here[self.column(x, -1)] - 2.0 * here[x] + here[self.column(x, 1)];
        let along_y = self.row(texels, y, -1)[x] - 2.0 * here[x] + self.row(texels, y, 1)[x];
        let at_end = |i: usize, len: usize| self.wrap == Wrap::Clamp && (i == 0 || i + 1 == len);
        [if at_end(x, self.width) { 0.0 } else { along_x }, if at_end(y, self.height) { 0.0 } else { along_y }]
    }
}

#[cfg(test)]
mod tests;
