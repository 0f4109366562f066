//! Slopes of texels, computed from arbitrary normals or from heights. The integration of heights inverts the difference
//! operators of this module.

use rayon::prelude::*;

use crate::limits::{check_size, zeroed};
use crate::material::{NormalMap, STEEPEST};
use crate::{HeightMap, MapFault, Wrap};

/// The difference operator that computes slopes from heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Difference {
    /// The mean slope of the drawn triangles over a texel's square, as in a [LEADR map](crate::LeadrMap). The central
    /// difference has weight 3/4 on the texel's own row, and weight 1/8 on each adjacent row.
    #[default]
    Triangles,
    /// Half the difference between the two neighbours.
    Central,
    /// The difference to the next texel, as in Chan 2018. A height then lies half a texel before its slope.
    Forward,
}

/// The number of invalid normals of each type. Every invalid normal still gets a slope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlopeFaults {
    /// The number of normals that are not finite or have zero length. The slopes of these normals are set to 0.
    pub broken: u64,
    /// The number of normals with `z <= 0`. A normal below the horizon gets the maximum slope in its direction.
    pub below_horizon: u64,
    /// The number of slopes clamped to [`STEEPEST`], excluding normals below the horizon.
    pub steep: u64,
    /// The number of normals whose length differs from 1 by more than 1/20. The length of a normal is ignored.
    pub not_unit: u64,
}

impl SlopeFaults {
    fn join(self, other: Self) -> Self {
        Self {
            broken: self.broken + other.broken,
            below_horizon: self.below_horizon + other.below_horizon,
            steep: self.steep + other.steep,
            not_unit: self.not_unit + other.not_unit,
        }
    }

    fn slope(&mut self, normal: [f32; 3]) -> [f32; 2] {
        let [x, y, z] = normal.map(f64::from);
        let length = (x * x + y * y + z * z).sqrt();
        if !(1e-12..1e30).contains(&length) {
            self.broken += 1;
            return [0.0; 2];
        }
        self.not_unit += u64::from((length - 1.0).abs() > 0.05);
        let across = x.hypot(y);
        if z <= 0.0 {
            self.below_horizon += 1;
        } else if across > STEEPEST * z {
            self.steep += 1;
        } else {
            return [x, y].map(|v| (-v / z) as f32);
        }
        [x, y].map(|v| (-STEEPEST * v / across.max(1e-12)) as f32)
    }
}

/// The upper limit of slopes from heights, which keeps squares and sums finite.
const STEEPEST_OF_HEIGHTS: f64 = 1e6;

/// The slopes of all texels, which are finite. Slopes from normals are at most [`STEEPEST`].
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Vec<[f32; 2]>,
    /// The number of invalid normals of each type.
    pub faults: SlopeFaults,
}

impl Slopes {
    /// Creates the map from row-major slopes. Values that are not finite become 0 and count as broken. Values above 1e6 are
    /// clamped.
    ///
    /// # Errors
    /// Fails if a side is 0, or if the number of texels is not `width * height`.
    pub fn new(width: u32, height: u32, mut texels: Vec<[f32; 2]>) -> Result<Self, MapFault> {
        check(width, height, texels.len())?;
        let mut faults = SlopeFaults::default();
        for texel in &mut texels {
            if texel.iter().all(|v| v.is_finite()) {
                *texel = texel.map(|v| v.clamp(-STEEPEST_OF_HEIGHTS as f32, STEEPEST_OF_HEIGHTS as f32));
            } else {
                faults.broken += 1;
                *texel = [0.0; 2];
            }
        }
        Ok(Self { width, height, texels, faults })
    }

    /// Computes slopes from row-major normals with y along `t` (down). All values are accepted, and [`SlopeFaults`] counts
    /// the invalid ones.
    ///
    /// # Errors
    /// Fails if a side is 0, or if the number of texels is not `width * height`.
    pub fn of_normals(width: u32, height: u32, normals: &[[f32; 3]]) -> Result<Self, MapFault> {
        check(width, height, normals.len())?;
        Self::of_texels(width, height, |x, y, faults| faults.slope(normals[y as usize * width as usize + x as usize]))
    }

    /// Computes the slopes of a normal map with [`NormalMap::slope`].
    ///
    /// # Errors
    /// Fails if memory runs out.
    pub fn of_normal_map(map: &NormalMap) -> Result<Self, MapFault> {
        let [width, height] = map.texture.raster.size();
        Self::of_texels(width, height, |x, y, faults| {
            let stored = map.slope(x, y).map(|v| v as f32);
            let finite = stored.iter().all(|v| v.is_finite());
            match map.vector(x, y) {
                Some(vector) => {
                    faults.slope(vector);
                }
                None => faults.broken += u64::from(!finite),
            }
            if finite { stored } else { [0.0; 2] }
        })
    }

    fn of_texels(
        width: u32,
        height: u32,
        slope: impl Fn(u32, u32, &mut SlopeFaults) -> [f32; 2] + Sync,
    ) -> Result<Self, MapFault> {
        let mut texels = zeroed::<[f32; 2]>(width as usize * height as usize)?;
        let rows = texels.par_chunks_mut(width as usize).zip(0..height).map(|(row, y)| {
            let mut faults = SlopeFaults::default();
            for (x, texel) in (0..).zip(row) {
                *texel = slope(x, y, &mut faults);
            }
            faults
        });
        let faults = rows.reduce(SlopeFaults::default, SlopeFaults::join);
        Ok(Self { width, height, texels, faults })
    }

    /// Returns the width and height in texels.
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Returns the row-major slopes.
    pub fn texels(&self) -> &[[f32; 2]] {
        &self.texels
    }

    /// Returns the mean slope.
    pub fn mean(&self) -> [f64; 2] {
        let rows = self.texels.par_chunks(self.width as usize);
        let sums: Vec<[f64; 2]> = rows
            .map(|row| row.iter().fold([0.0; 2], |sum, v| [sum[0] + f64::from(v[0]), sum[1] + f64::from(v[1])]))
            .collect();
        let sum = sums.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        sum.map(|v| v / self.texels.len() as f64)
    }

    /// Returns the RMS angle in degrees between the normals of these slopes and the normals of `other`.
    ///
    /// # Panics
    /// Panics if the sizes differ.
    pub fn angle_to(&self, other: &Self) -> f64 {
        assert_eq!(self.size(), other.size(), "slopes of two sizes");
        let unit = |[x, y]: [f32; 2]| {
            let [x, y] = [f64::from(x), f64::from(y)];
            let length = (1.0 + x * x + y * y).sqrt();
            [-x / length, -y / length, 1.0 / length]
        };
        let rows = self.texels.par_chunks(self.width as usize).zip(other.texels.par_chunks(self.width as usize));
        let square = |(a, b): (&[f32; 2], &[f32; 2])| {
            let (a, b) = (unit(*a), unit(*b));
            // The angle is computed from the chord, since the arc cosine is inaccurate for small angles.
            let chord = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
            (2.0 * (0.5 * chord).min(1.0).asin()).powi(2)
        };
        let sums: Vec<f64> = rows.map(|(a, b)| a.iter().zip(b).map(square).sum()).collect();
        (sums.iter().sum::<f64>() / self.texels.len() as f64).sqrt().to_degrees()
    }
}

fn check(width: u32, height: u32, len: usize) -> Result<(), MapFault> {
    check_size(width.into(), height.into(), 8, usize::MAX)?;
    if u64::from(width) * u64::from(height) != len as u64 {
        return Err(MapFault::SizeMismatch { what: format!("{len} texels were given for {width} x {height}") });
    }
    Ok(())
}

/// Computes the slopes of heights. `scale` converts heights to texture widths. A texel at the edge of a non-repeating map
/// uses its single neighbour.
pub fn slopes_of_heights(heights: &HeightMap, scale: f32, wrap: Wrap, difference: Difference) -> Slopes {
    let (width, height) = (heights.width, heights.height);
    let per_texel = f64::from(scale) * f64::from(width);
    let mut texels = vec![[0.0; 2]; heights.texels.len()];
    texels.par_chunks_mut(width as usize).zip(0..height).for_each(|(row, y)| {
        for (x, slope) in (0..).zip(row) {
            *slope = differences(heights, wrap, difference, x, y)
                .map(|v| (per_texel * v).clamp(-STEEPEST_OF_HEIGHTS, STEEPEST_OF_HEIGHTS) as f32);
        }
    });
    Slopes { width, height, texels, faults: SlopeFaults::default() }
}

/// Returns the slopes at a texel in units of height per texel.
fn differences(map: &HeightMap, wrap: Wrap, difference: Difference, x: u32, y: u32) -> [f64; 2] {
    let at = |x: usize, y: usize| f64::from(map.texels[y * map.width as usize + x]);
    let near = |k: u32, of: u32| match k {
        _ if k > 0 && k + 1 < of => [k - 1, k, k + 1].map(|k| k as usize),
        _ => [-1, 0, 1].map(|step| wrap.texel(i64::from(k) + step, of)),
    };
    let ([x0, x1, x2], [y0, y1, y2]) = (near(x, map.width), near(y, map.height));
    // At a non-repeating edge, the two samples are one texel apart instead of two.
    let by = |a: usize, b: usize, of: u32| match wrap {
        Wrap::Repeat => 0.5,
        Wrap::Clamp if of > 1 => 1.0 / (b - a) as f64,
        Wrap::Clamp => 0.0,
    };
    let (across, down) = (by(x0, x2, map.width), by(y0, y2, map.height));
    let mean = |[a, b, c]: [f64; 3]| 0.125 * (a + c) + 0.75 * b;
    match difference {
        Difference::Triangles => [
            across * mean([y0, y1, y2].map(|y| at(x2, y) - at(x0, y))),
            down * mean([x0, x1, x2].map(|x| at(x, y2) - at(x, y0))),
        ],
        Difference::Central => [across * (at(x2, y1) - at(x0, y1)), down * (at(x1, y2) - at(x1, y0))],
        Difference::Forward => {
            let ahead =
                |here: usize, next: usize, before: usize| if here == next { [before, here] } else { [here, next] };
            let ([a, b], [c, d]) = (ahead(x1, x2, x0), ahead(y1, y2, y0));
            [at(b, y1) - at(a, y1), at(x1, d) - at(x1, c)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LeadrMap;

    fn noise(width: u32, height: u32) -> HeightMap {
        let texel = |i: u32| ((i.wrapping_mul(0x9e37_79b1) ^ 0x51).wrapping_mul(0x85eb_ca6b) >> 8) as f32 / 2e8;
        HeightMap::new(width, height, (0..width * height).map(texel).collect()).unwrap()
    }

    #[test]
    fn triangles_have_the_mean_slopes_of_leadr_maps() {
        for (width, height) in [(32, 32), (17, 9), (1, 8), (8, 1), (1, 1)] {
            let map = noise(width, height);
            let leadr = LeadrMap::new(&map, Wrap::Repeat);
            let slopes = slopes_of_heights(&map, 1.0, Wrap::Repeat, Difference::Triangles);
            for (slope, moments) in slopes.texels.iter().zip(&leadr.levels[0].texels) {
                // Moments have slopes per unit texture coordinate.
                let [s, t] = moments.mean_slope;
                let expected = [s, t * width as f32 / height as f32];
                assert!((0..2).all(|i| (slope[i] - expected[i]).abs() < 1e-4), "{slope:?} {expected:?}");
            }
        }
    }

    #[test]
    fn planes_have_one_slope_up_to_the_edge() {
        let plane = |i: u32| 0.25 * (i % 16) as f32 / 16.0 - 0.5 * (i / 16) as f32 / 16.0;
        let map = HeightMap::new(16, 8, (0..128).map(plane).collect()).unwrap();
        for difference in [Difference::Triangles, Difference::Central, Difference::Forward] {
            let slopes = slopes_of_heights(&map, 2.0, Wrap::Clamp, difference);
            assert!(slopes.texels.iter().all(|s| (s[0] - 0.5).abs() < 1e-5 && (s[1] + 1.0).abs() < 1e-5), "{slopes:?}");
        }
    }

    #[test]
    fn anything_is_a_normal() {
        let (nan, huge) = (f32::NAN, f32::MAX);
        let normals = [
            [0.0, 0.0, 1.0],
            [0.0; 3],
            [nan, 0.0, 1.0],
            [huge, huge, huge],
            [0.6, 0.0, -0.8],
            [0.0, 0.0, -1.0],
            [0.999, 0.0, 0.0447],
            [0.0, 1.2, 1.6],
        ];
        let slopes = Slopes::of_normals(4, 2, &normals).unwrap();
        let steepest = STEEPEST as f32;
        let expected =
            [[0.0, 0.0], [0.0; 2], [0.0; 2], [0.0; 2], [-steepest, 0.0], [0.0; 2], [-steepest, 0.0], [0.0, -0.75]];
        for (slope, expected) in slopes.texels.iter().zip(expected) {
            assert!((0..2).all(|i| (slope[i] - expected[i]).abs() < 1e-6), "{slope:?} {expected:?}");
        }
        let faults = SlopeFaults { broken: 3, below_horizon: 2, steep: 1, not_unit: 1 };
        assert_eq!(slopes.faults, faults);
        assert!(Slopes::of_normals(4, 3, &normals).is_err() && Slopes::of_normals(0, 0, &[]).is_err());
        let given = Slopes::new(2, 1, vec![[nan, 1.0], [0.5, huge]]).unwrap();
        assert_eq!((given.texels, given.faults.broken), (vec![[0.0; 2], [0.5, 1e6]], 1));
    }
}
