//! Filtering of normals and roughness through the mean normal length. The filter averages shortened normals, then decodes the normal and
//! the roughness from the mean (Chan 2018, Algorithms 1–3).
//!
//! A texel of unit normal `n` and roughness `α` becomes four numbers that any linear filter may average: the sum of its facet normals, and
//! the area that weights them. Per unit of texture area, with the mean normal length `L(α)` from [`Shortening`], the numbers are
//!
//! ```text
//! macro:  (L n, 1)                      facets weighted by macrosurface area
//! micro:  (n, 1/L) / cos θ              weighted by their own area: 1/cos θ for the plane, times 1/L
//! ```
//!
//! The sum weighted by microsurface area has `z = 1`, so its direction is the normal of the mean slope, which is LEADR's mesonormal.
//! Algorithm 1 uses the plane area `1/cos θ` only, and ignores the larger facet area of rough texels. Macro sums have weight 1 and micro
//! sums have `z = 1`, so either sum needs only three numbers.

use super::shortened_normals::{NormalArea, Shortening};
use crate::limits::{MAX_SLOPE, MIN_NORMAL_Z};
use crate::quadrature::gauss_legendre;
use glam::{DVec3, DVec4};

/// A texel of a normal map, together with its roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTexel {
    /// The unit normal.
    pub normal: DVec3,
    /// The roughness `α`.
    pub alpha: f64,
}

impl NormalTexel {
    /// Returns the normalised normal, raised above the horizon. A normal without a direction becomes z.
    fn direction(&self) -> DVec3 {
        let n = self.normal;
        let length = n.length();
        if !(length > 1e-12 && length.is_finite()) {
            return DVec3::Z;
        }
        let n = n / length;
        if n.z >= MIN_NORMAL_Z { n } else { n.truncate().extend(MIN_NORMAL_Z).normalize() }
    }

    fn alpha(&self) -> f64 {
        if self.alpha.is_nan() { MAX_SLOPE } else { self.alpha }
    }
}

/// Returns the normal sum and the area of a texel, per unit of texture area.
///
/// The average of these sums represents a footprint, and [`texel_of_sum`] decodes it. Normals below the horizon are clamped to
/// [`MIN_NORMAL_Z`]. A normal without a direction becomes z, and a NaN roughness becomes the largest roughness.
pub fn normal_sum(texel: &NormalTexel, shortening: Shortening) -> DVec4 {
    let (normal, length) = (texel.direction(), shortening.length(texel.alpha()));
    match shortening.area {
        NormalArea::Macro => (normal * length).extend(1.0),
        NormalArea::Micro => (normal / normal.z).extend(1.0 / (normal.z * length)),
    }
}

/// Decodes a sum or mean of [`normal_sum`]s to a normal and a roughness. A sum that has no area or no direction gives the normal z and the
/// largest roughness.
pub fn texel_of_sum(sum: DVec4, shortening: Shortening) -> NormalTexel {
    let mean = sum.truncate() / sum.w;
    let length = mean.length();
    if sum.w > 0.0 && length > 1e-12 && length.is_finite() {
        NormalTexel { normal: mean / length, alpha: shortening.alpha_of_length(length) }
    } else {
        NormalTexel { normal: DVec3::Z, alpha: MAX_SLOPE }
    }
}

/// Returns the box-filtered mean of texels of equal size (Chan's Algorithm 3).
pub fn mean_texel(texels: &[NormalTexel], shortening: Shortening) -> NormalTexel {
    texel_of_sum(texels.iter().map(|t| normal_sum(t, shortening)).sum(), shortening)
}

/// Returns the normal sum of a texel on a continuous surface, instead of one flat facet per texel (Chan 2018, section 2.3). Normals and
/// roughness are interpolated between texel centres, and the footprint is one texel wide.
///
/// `around[row][column]` holds the central texel and its eight neighbours. The function integrates bilinear normals and bilinear roughness
/// at 4 × 4 Gauss–Legendre points per quarter of the texel. The error of `1 − L` is 3e-5 if neighbours differ by 120°. Under magnification
/// a pixel covers less than a texel, so this sum overestimates roughness.
pub fn continuous_normal_sum(around: &[[NormalTexel; 3]; 3], shortening: Shortening) -> DVec4 {
    let normals = around.map(|row| row.map(|t| t.direction()));
    let alphas = around.map(|row| row.map(|t| t.alpha()));
    let rule = gauss_legendre(4);
    let mut sum = DVec4::ZERO;
    // Integrate the quarter of the texel towards the neighbour in column i and row j. The fractions x and y of the distance to that
    // neighbour's centre are at most one half.
    for (i, j) in [(0, 0), (2, 0), (0, 2), (2, 2)] {
        for &(x, wx) in &rule {
            for &(y, wy) in &rule {
                let (x, y) = (0.25 * (1.0 + x), 0.25 * (1.0 + y));
                let shares = [
                    ((1, 1), (1.0 - x) * (1.0 - y)),
                    ((1, i), x * (1.0 - y)),
                    ((j, 1), (1.0 - x) * y),
                    ((j, i), x * y),
                ];
                let normal = shares.iter().map(|&((r, c), w)| normals[r][c] * w).sum();
                let alpha = shares.iter().map(|&((r, c), w)| alphas[r][c] * w).sum();
                sum += 0.0625 * wx * wy * normal_sum(&NormalTexel { normal, alpha }, shortening);
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::shortened_normals::NormalFacets;
    use crate::slopes::grid::normal_of_slope;
    use crate::slopes::moments::slope_of_normal;
    use glam::DVec2;

    fn texel(x: f64, y: f64, alpha: f64) -> NormalTexel {
        NormalTexel { normal: normal_of_slope(DVec2::new(x, y)), alpha }
    }

    #[test]
    fn one_texel_is_itself() {
        for shortening in Shortening::ALL {
            for t in [texel(0.3, -0.2, 0.1), texel(0.0, 0.0, 0.003), texel(-2.0, 1.0, 1.0)] {
                let back = mean_texel(&[t; 5], shortening);
                assert!((back.normal - t.normal).length() < 1e-12, "{shortening:?}");
                assert!((back.alpha / t.alpha - 1.0).abs() < 1e-9, "{shortening:?} {} {}", back.alpha, t.alpha);
            }
        }
    }

    /// The sums of perfectly smooth texels equal Algorithms 1 and 2 of Chan's paper.
    #[test]
    fn sums_are_the_paper_s_algorithms() {
        let texels = [texel(0.3, -0.2, 0.0), texel(-1.0, 0.4, 0.0), texel(0.1, 0.9, 0.0)];
        let (mut micro, mut weight, mut plain) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for t in texels {
            micro += t.normal / t.normal.z;
            weight += 1.0 / t.normal.z;
            plain += t.normal / 3.0;
        }
        for (area, want) in [(NormalArea::Micro, micro / weight), (NormalArea::Macro, plain)] {
            let shortening = Shortening { area, ..Shortening::default() };
            let sum: DVec4 = texels.iter().map(|t| normal_sum(t, shortening)).sum();
            assert!((sum.truncate() / sum.w - want).length() < 1e-6, "{area:?}");
        }
    }

    /// Texels whose normals follow the distribution of a roughness decode to this roughness, for both area measures.
    #[test]
    fn facets_as_texels_give_their_roughness() {
        for alpha in [0.05, 0.3, 0.8] {
            for shortening in Shortening::ALL {
                let texels: Vec<NormalTexel> = (0..4000 * 4)
                    .map(|i| {
                        // The slope lengths are evenly spaced quantiles.
                        let v = (f64::from(i / 4) + 0.5) / 4000.0;
                        let slope = alpha
                            * match shortening.facets {
                                NormalFacets::Ggx => (v / (1.0 - v)).sqrt(),
                                NormalFacets::Beckmann => (-(1.0 - v).ln()).sqrt(),
                            };
                        let at = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y][i as usize % 4] * slope;
                        NormalTexel { normal: normal_of_slope(at), alpha: 0.0 }
                    })
                    .collect();
                let found = mean_texel(&texels, shortening).alpha;
                // The highest quantile truncates the long tail of GGX, so the tolerance is large.
                assert!((found / alpha - 1.0).abs() < 0.04, "{shortening:?} {alpha}: {found}");
            }
        }
    }

    /// The mean normal weighted by microsurface area is the normal of the mean slope, for any texel roughness.
    #[test]
    fn microsurface_sums_keep_the_mean_slope() {
        let shortening = Shortening { area: NormalArea::Micro, ..Shortening::default() };
        let texels = [texel(0.3, -0.2, 0.7), texel(-1.0, 0.4, 0.01), texel(0.1, 0.9, 0.2)];
        let found = mean_texel(&texels, shortening);
        assert!((slope_of_normal(found.normal) - DVec2::new(-0.2, 1.1 / 3.0)).length() < 1e-12);
        // The mean normal weighted by macrosurface area is biased towards the smoother texel (Chan's Figure 7).
        let macro_area = mean_texel(&[texel(0.5, 0.0, 0.05), texel(-0.5, 0.0, 0.9)], Shortening::default());
        assert!(slope_of_normal(macro_area.normal).x > 0.05);
    }

    #[test]
    fn continuous_texels_spread_by_their_neighbours() {
        let shortening = Shortening { facets: NormalFacets::Beckmann, area: NormalArea::Macro };
        // On a paraboloid, slopes change by d per texel, so their variance within a texel is d²/12 per axis.
        for d in [0.01, 0.05] {
            let around = [-1.0, 0.0, 1.0].map(|y| [-1.0, 0.0, 1.0].map(|x| texel(d * x, d * y, 0.05)));
            let found = texel_of_sum(continuous_normal_sum(&around, shortening), shortening);
            let want = 0.05f64.powi(2) + 2.0 * d * d / 12.0;
            assert!((found.alpha.powi(2) / want - 1.0).abs() < 2e-3, "{d}: {} {want}", found.alpha.powi(2));
            assert!((found.normal - DVec3::Z).length() < 1e-12);
        }
        // Neighbours equal to the centre change nothing, and both axes give the same result.
        let flat = [[texel(0.2, 0.1, 0.3); 3]; 3];
        let back = texel_of_sum(continuous_normal_sum(&flat, shortening), shortening);
        assert!((back.normal - flat[0][0].normal).length() < 1e-12 && (back.alpha - 0.3).abs() < 1e-9);
        let lean = [0, 1, 2].map(|_| [texel(0.0, 0.0, 0.1), texel(0.0, 0.0, 0.1), texel(0.8, 0.0, 0.1)]);
        let rotated = [texel(0.0, 0.0, 0.1), texel(0.0, 0.0, 0.1), texel(0.0, 0.8, 0.1)].map(|t| [t; 3]);
        let (a, b) = (continuous_normal_sum(&lean, shortening), continuous_normal_sum(&rotated, shortening));
        assert!((a.x - b.y).abs() < 1e-14 && a.x < -0.05 && a.y.abs() < 1e-14 && (a.z - b.z).abs() < 1e-14);
    }

    /// Compares the texel quadrature with a midpoint rule of 256 times as many points.
    #[test]
    fn the_quadrature_of_a_texel_has_converged() {
        let shortening = Shortening::default();
        let mut worst = 0.0f64;
        for steep in [0.2, 0.6, 1.7] {
            let signs = [[1.0, -1.0, 0.3], [0.0, 0.1, -1.0], [-0.5, 1.0, 0.7]];
            let around = signs.map(|row| row.map(|s| texel(steep * s, -0.5 * steep * s, 0.1 + 0.1 * steep)));
            let got = continuous_normal_sum(&around, shortening);
            let mut want = DVec4::ZERO;
            let n = 128;
            for k in 0..n * n {
                let at = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
                let (x, y) = (at(k % n), at(k / n));
                let (i, j) = (if x > 0.0 { 2 } else { 0 }, if y > 0.0 { 2 } else { 0 });
                let (x, y) = (x.abs(), y.abs());
                let mix = |a: DVec3, b: DVec3, t: f64| a + (b - a) * t;
                let row = |r: usize| mix(around[r][1].normal, around[r][i].normal, x);
                let normal = mix(row(1), row(j), y);
                let alpha = around[1][1].alpha;
                want += normal_sum(&NormalTexel { normal, alpha }, shortening) / (n * n) as f64;
            }
            let (one_minus_length, exact) = (1.0 - got.truncate().length(), 1.0 - want.truncate().length());
            worst = worst.max((one_minus_length / exact - 1.0).abs());
        }
        println!("4 x 4 points per quarter of a texel: largest relative error of 1 - L {worst:.1e}");
        assert!(worst < 3e-4);
    }

    #[test]
    fn any_texels_have_a_mean() {
        let odd = [DVec3::ZERO, DVec3::NEG_Z, DVec3::splat(f64::NAN), DVec3::X, DVec3::splat(1e300)];
        for shortening in Shortening::ALL {
            for normal in odd {
                for alpha in [f64::NAN, -1.0, 0.0, 1e300] {
                    let t = NormalTexel { normal, alpha };
                    for found in [
                        mean_texel(&[t; 2], shortening),
                        mean_texel(&[t, texel(0.0, 0.0, 0.1)], shortening),
                        texel_of_sum(continuous_normal_sum(&[[t; 3]; 3], shortening), shortening),
                    ] {
                        assert!((found.normal.length() - 1.0).abs() < 1e-9 && (1e-4..=100.0).contains(&found.alpha));
                    }
                }
            }
            for sum in
                [DVec4::ZERO, DVec4::splat(f64::NAN), DVec4::new(0.0, 0.0, 1.0, -1.0), DVec4::new(0.0, 0.0, 5.0, 1.0)]
            {
                let found = texel_of_sum(sum, shortening);
                assert!(found.normal.is_normalized() && (1e-4..=100.0).contains(&found.alpha));
            }
        }
    }
}
