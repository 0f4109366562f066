//! The algebra of slope moments. A LEADR map stores these moments, and the functions of this module change them with the surface (LEADR
//! 4.1–4.2; thesis 3.3, 3.4, 5.1).
//!
//! Each texel has five numbers: `E[x]`, `E[y]`, `E[x²]`, `E[y²]`, `E[xy]`. They are averages over slope samples, so any linear filter may
//! average them further. The operations of this module are exact for every slope distribution, Gaussian or not. The only approximation is
//! to interpret the moments as a Beckmann distribution. Texture-space slopes are per unit texture coordinate.
//!
//! Moments with steep means and small variances suffer from cancellation. In 32 bits, shear or add moments *before* filtering, not after
//! it, or use the mean and the covariance ([`covariance_from_moments`]).

use super::statistics::{covariance_from_moments, map_second_moments, outer_square};
use crate::limits::{MAX_SLOPE, MIN_NORMAL_Z};
use glam::{DMat2, DVec2, DVec3, DVec4};

/// The first and second moments of slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeMoments {
    /// The mean slope `(E[x], E[y])`.
    pub first: DVec2,
    /// The second moments `(E[x²], E[y²], E[xy])`.
    pub second: DVec3,
}

/// Returns the moments of one slope sample, which are its first and second powers.
pub fn moments_of_slope(slope: DVec2) -> SlopeMoments {
    SlopeMoments { first: slope, second: outer_square(slope) }
}

/// Returns the slope of a normal of any length, `(-n.x / n.z, -n.y / n.z)`, with its magnitude clamped to [`MAX_SLOPE`]. Normals below the
/// horizon are treated as lying on it.
pub fn slope_of_normal(n: DVec3) -> DVec2 {
    let n = n / n.length_squared().max(1e-30).sqrt();
    let slope = -n.truncate() / n.z.max(MIN_NORMAL_Z);
    slope * (MAX_SLOPE / slope.length_squared().max(1e-12).sqrt()).min(1.0)
}

/// Returns the moments of one sample of a normal map (thesis, listing 3.7; [`roughen_moments`] adds its base roughness).
pub fn moments_of_normal(n: DVec3) -> SlopeMoments {
    moments_of_slope(slope_of_normal(n))
}

/// Returns the slope at a texel from its neighbours' `heights` (at −s, +s, −t, +t), by central differences (thesis 3.4). Central
/// differences miss detail between texels, so maps use [`moments_of_corner`]. `spacing` is the positive distance between texels. For slopes
/// per unit texture coordinate, it is one over the number of texels.
pub fn slope_of_heights(heights: DVec4, spacing: DVec2) -> DVec2 {
    DVec2::new(heights.y - heights.x, heights.w - heights.z) / (2.0 * spacing).max(DVec2::splat(1e-12))
}

/// Returns the moments of a height field's triangles over the quarter of a cell at its first corner.
///
/// `heights` are the heights at this corner, at its neighbour along `s`, at its neighbour along `t`, and at the diagonally opposite corner.
/// `spacing` is the nonzero texel distance. It is negative where `s` or `t` decreases, so that one function serves all four corners.
///
/// A cell between four texels has four triangles, which meet in its centre at the mean height of its corners. Let `a` be the difference
/// along `s` at this corner, and `b` the difference along `s` on the opposite edge. Let `c` and `d` be the same differences along `t`. Half
/// of the quarter has the slope `(a, (c + d)/2)` of the triangle on the edge along `s`, and half has the slope `((a + b)/2, c)` of the
/// triangle on the edge along `t`. Differences are bounded to 1e18, so that 32 bits hold their squares.
pub fn moments_of_corner(heights: DVec4, spacing: DVec2) -> SlopeMoments {
    let (x, y) = (spacing.x, spacing.y);
    let bound = DVec2::splat(1e18);
    let beside = DVec2::new((heights.y - heights.x) / x, (heights.z - heights.x) / y).clamp(-bound, bound);
    let opposite = DVec2::new((heights.w - heights.z) / x, (heights.w - heights.y) / y).clamp(-bound, bound);
    let mean = 0.5 * (beside + opposite);
    let squares = 0.5 * (beside * beside + mean * mean);
    let mixed = 0.5 * (beside.x * mean.y + mean.x * beside.y);
    SlopeMoments { first: 0.5 * (beside + mean), second: squares.extend(mixed) }
}

/// Returns the moments of a Gaussian of mean slope `m` and covariance `s`. This function is the inverse of [`covariance_from_moments`]
/// (thesis eq. 3.5–3.9, `s = α²/2`).
pub fn moments_of_distribution(m: DVec2, s: DVec3) -> SlopeMoments {
    shear_moments(SlopeMoments { first: DVec2::ZERO, second: s }, m)
}

/// Returns the moments of a surface that has the moments `b` over the fraction `t` of its area, from 0 to 1, and the moments `a` elsewhere.
/// Texture filters compute the same mixture.
pub fn mix_moments(a: SlopeMoments, b: SlopeMoments, t: f64) -> SlopeMoments {
    SlopeMoments { first: a.first.lerp(b.first, t), second: a.second.lerp(b.second, t) }
}

/// Returns the moments of the sum of two displacements with independent slopes (thesis 5.1): `E[Z²] = E[X²] + E[Y²] + 2 E[X] E[Y]`,
/// `E[Z_x Z_y] = E[X_x X_y] + E[Y_x Y_y] + E[X_x] E[Y_y] + E[X_y] E[Y_x]`.
///
/// Listing 5.1 of the thesis has an erratum: its `+=` adds the second moments using means that are already summed. This function reads both
/// operands before it writes the sums.
pub fn add_moments(a: SlopeMoments, b: SlopeMoments) -> SlopeMoments {
    let (p, q) = (a.first, b.first);
    let mixed = DVec3::new(2.0 * p.x * q.x, 2.0 * p.y * q.y, p.x * q.y + p.y * q.x);
    SlopeMoments { first: p + q, second: a.second + b.second + mixed }
}

/// Returns the moments of slopes multiplied by an independent mask: `E[m X] = E[m] E[X]` and `E[m² X Xᵀ] = E[m²] E[X Xᵀ]`. `mask` is `E[m]`
/// and `E[m²]`, so a filtered mask keeps more variance than the mean of the mask would. Masking slopes instead of heights neglects the term
/// `h ∇m`.
pub fn mask_moments(a: SlopeMoments, mask: DVec2) -> SlopeMoments {
    SlopeMoments { first: a.first * mask.x, second: a.second * mask.y }
}

/// Returns the moments after multiplying heights by `eta` (LEADR 4.2, Height Scaling).
pub fn scale_moments(a: SlopeMoments, eta: f64) -> SlopeMoments {
    SlopeMoments { first: a.first * eta, second: a.second * (eta * eta) }
}

/// Returns the moments after adding a plane of slope `shear` to the heights: `E[(X+c)(Y+d)] = E[XY] + d E[X] + c E[Y] + cd`. The covariance
/// does not change.
pub fn shear_moments(a: SlopeMoments, shear: DVec2) -> SlopeMoments {
    add_moments(a, moments_of_slope(shear))
}

/// Returns the moments in another frame with slopes `linear · (h_s, h_t)` (LEADR eq. 12; thesis 3.4, "Stretching and Shearing"). `linear`
/// is the transposed Jacobian of `(s, t)` by `(x, y)`, which `slopes::map::slope_map` computes from tangents.
pub fn map_moments(linear: DMat2, a: SlopeMoments) -> SlopeMoments {
    SlopeMoments { first: linear * a.first, second: map_second_moments(linear, a.second) }
}

/// Adds a base material of Beckmann roughness `alpha` to the moments, with `σ² = α²/2` per axis (LEADR 4.1; thesis, listing 3.7).
pub fn roughen_moments(a: SlopeMoments, alpha: f64) -> SlopeMoments {
    SlopeMoments { first: a.first, second: a.second + DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0) }
}

/// Returns the covariance of the slopes, in any unit (LEADR eq. 9; [`covariance_from_moments`]).
pub fn moments_covariance(a: SlopeMoments) -> DVec3 {
    covariance_from_moments(a.first, a.second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A sum of waves with exact slopes, which are neither Gaussian nor isotropic nor centred.
    struct Waves([[f64; 4]; 4]);

    const COARSE: Waves =
        Waves([[3.1, 1.2, 0.3, 0.1], [-2.3, 4.7, 1.7, 0.07], [7.9, -5.3, 2.9, 0.03], [0.9, 0.4, 0.2, 0.2]]);
    const FINE: Waves =
        Waves([[31.0, 9.0, 1.1, 0.02], [-17.0, 43.0, 2.3, 0.006], [23.0, 29.0, 0.7, 0.01], [53.0, -3.0, 5.1, 0.004]]);

    impl Waves {
        fn height(&self, p: DVec2) -> f64 {
            // Squaring makes crests differ from troughs.
            self.0.iter().map(|[kx, ky, phase, a]| a * (1.0 + (kx * p.x + ky * p.y + phase).sin()).powi(2)).sum()
        }

        fn slope(&self, p: DVec2) -> DVec2 {
            let wave = |[kx, ky, phase, a]: &[f64; 4]| {
                let (sin, cos) = (kx * p.x + ky * p.y + phase).sin_cos();
                DVec2::new(*kx, *ky) * (2.0 * a * (1.0 + sin) * cos)
            };
            self.0.iter().map(wave).sum()
        }
    }

    fn points(seed: u64, n: usize) -> impl Iterator<Item = DVec2> {
        let mut random = Random(seed);
        (0..n).map(move |_| DVec2::new(random.unit(), random.unit()))
    }

    fn mean(samples: impl Iterator<Item = DVec2>) -> SlopeMoments {
        let (mut sum, mut n) = (SlopeMoments::default(), 0.0);
        for m in samples.map(moments_of_slope) {
            sum.first += m.first;
            sum.second += m.second;
            n += 1.0;
        }
        SlopeMoments { first: sum.first / n, second: sum.second / n }
    }

    fn distance(a: SlopeMoments, b: SlopeMoments) -> f64 {
        (a.first - b.first).length() + (a.second - b.second).length()
    }

    const N: usize = 200_000;

    /// Scaling, shearing, a change of frame, and mixing give the same moments up to rounding, whether they are applied to samples or to
    /// moments.
    #[test]
    fn deterministic_operations_are_those_of_the_samples() {
        let all = || points(1, N).map(|p| COARSE.slope(p));
        let moments = mean(all());
        let linear = DMat2::from_cols_array(&[1.3, -0.4, 0.8, 0.6]);
        let shear = DVec2::new(0.7, -1.9);
        for (what, sampled, derived) in [
            ("height scale", mean(all().map(|x| -1.7 * x)), scale_moments(moments, -1.7)),
            ("shear", mean(all().map(|x| x + shear)), shear_moments(moments, shear)),
            ("change of frame", mean(all().map(|x| linear * x)), map_moments(linear, moments)),
            (
                "mixture",
                mean(all().take(N / 4)),
                mix_moments(mean(all().take(N / 8)), mean(all().skip(N / 8).take(N / 8)), 0.5),
            ),
        ] {
            let error = distance(sampled, derived) / (moments.first.length() + moments.second.length());
            println!("{what}: {error:.1e}");
            assert!(error < 1e-12, "{what}: {derived:?} instead of {sampled:?}");
        }
        // Without the cross term of the shear, the error must be large.
        let forgotten = SlopeMoments {
            first: moments.first + shear,
            second: moments.second + DVec3::new(shear.x * shear.x, shear.y * shear.y, shear.x * shear.y),
        };
        assert!(distance(forgotten, shear_moments(moments, shear)) > 0.1);
    }

    /// The moments of a sum of two layers agree with samples at independent points, within five standard errors.
    #[test]
    fn layers_add_as_sampled_surfaces_do() {
        let n = 4 * N;
        // The tilt makes the mixed terms significant.
        let fine_slope = |p| FINE.slope(p) + DVec2::new(0.4, -0.3);
        let (coarse, fine) = (mean(points(2, n).map(|p| COARSE.slope(p))), mean(points(3, n).map(fine_slope)));
        let sum = || points(2, n).zip(points(3, n)).map(|(p, q)| COARSE.slope(p) + fine_slope(q));
        let (sampled, derived) = (mean(sum()), add_moments(coarse, fine));
        let fourth = sum().map(|x| x.length_squared().powi(2)).sum::<f64>() / n as f64;
        let standard_error = (fourth / n as f64).sqrt();
        let error = distance(sampled, derived);
        println!("layers: error {error:.1e}, five standard errors {:.1e}", 5.0 * standard_error);
        assert!(error < 5.0 * standard_error && standard_error < 1e-2 * derived.second.length());
        // Adding the means first, as in the thesis's listing 5.1, gives a much larger error.
        let p = coarse.first + fine.first;
        let listing = coarse.second.x + fine.second.x + 2.0 * p.x * fine.first.x;
        println!("listing 5.1: {listing:.4} instead of {:.4}", derived.second.x);
        assert!((listing - derived.second.x).abs() > 20.0 * standard_error);
    }

    /// The moments of a base plus masked detail agree with samples at independent points.
    #[test]
    fn masked_layers_add_as_sampled_surfaces_do() {
        let n = 4 * N;
        let mask = |p: DVec2| ((9.0 * p.x).sin() * (7.0 * p.y).cos() * 2.0 + 0.3).clamp(0.0, 1.0);
        let fine_slope = |p| FINE.slope(p) + DVec2::new(0.4, -0.3);
        let (coarse, fine) = (mean(points(2, n).map(|p| COARSE.slope(p))), mean(points(3, n).map(fine_slope)));
        let of_mask = points(5, n).map(mask).fold(DVec2::ZERO, |sum, m| sum + DVec2::new(m, m * m)) / n as f64;
        let sum = || {
            let triples = points(2, n).zip(points(3, n)).zip(points(5, n));
            triples.map(|((p, q), r)| COARSE.slope(p) + mask(r) * fine_slope(q))
        };
        let (sampled, derived) = (mean(sum()), add_moments(coarse, mask_moments(fine, of_mask)));
        let fourth = sum().map(|x| x.length_squared().powi(2)).sum::<f64>() / n as f64;
        let standard_error = (fourth / n as f64).sqrt();
        let error = distance(sampled, derived);
        println!("masked layers: error {error:.1e}, five standard errors {:.1e}", 5.0 * standard_error);
        assert!(error < 5.0 * standard_error && standard_error < 1e-2 * derived.second.length());
        // Using the squared mean of the mask instead of `E[m²]` gives a large error.
        let naive = add_moments(coarse, scale_moments(fine, of_mask.x));
        assert!(distance(sampled, naive) > 20.0 * standard_error);
    }

    /// A base roughness, and a distribution with a mean and a covariance, are both independent layers of Gaussian slopes.
    #[test]
    fn roughness_is_a_layer() {
        let alpha = 0.4;
        let gaussian = points(5, N).map(|u| {
            let radius = (-2.0 * (1.0 - u.x).ln()).sqrt() * alpha / 2f64.sqrt();
            DVec2::from_angle(std::f64::consts::TAU * u.y) * radius
        });
        let coarse = mean(points(4, N).map(|p| COARSE.slope(p)));
        let sampled = mean(points(4, N).zip(gaussian).map(|(p, g)| COARSE.slope(p) + g));
        let derived = roughen_moments(coarse, alpha);
        assert!(distance(sampled, derived) < 0.01 * derived.second.length(), "{derived:?} instead of {sampled:?}");
        let (m, s) = (DVec2::new(0.3, -0.8), DVec3::new(0.2, 0.1, -0.05));
        assert!((moments_covariance(moments_of_distribution(m, s)) - s).length() < 1e-15);
        assert_eq!(moments_of_distribution(m, s).first, m);
        let layer =
            add_moments(coarse, moments_of_distribution(DVec2::ZERO, 0.5 * alpha * alpha * DVec3::new(1.0, 1.0, 0.0)));
        assert!(distance(layer, derived) < 1e-15);
    }

    /// The heights, normals and slopes of one surface agree, even in a frame that stretches and shears.
    #[test]
    fn inputs_agree() {
        let jacobian = DMat2::from_cols_array(&[0.9, 0.3, -0.5, 1.4]); // Jacobian of (s, t) by (x, y)
        for p in points(6, 1000) {
            let slope = COARSE.slope(p);
            let from_normal = slope_of_normal(DVec3::new(-slope.x, -slope.y, 1.0) * 0.3);
            assert!((from_normal - slope).length() < 1e-12 * (1.0 + slope.length()));
            let d = 1e-5;
            let around = |f: &dyn Fn(DVec2) -> f64, at: DVec2| {
                DVec4::new(f(at - DVec2::X * d), f(at + DVec2::X * d), f(at - DVec2::Y * d), f(at + DVec2::Y * d))
            };
            let central = slope_of_heights(around(&|q| COARSE.height(q), p), DVec2::splat(d));
            assert!((central - slope).length() < 1e-6, "{central} instead of {slope}");
            // This is the slope of the deformed surface, from its own heights.
            let deformed =
                slope_of_heights(around(&|q| COARSE.height(jacobian * q), jacobian.inverse() * p), DVec2::splat(d));
            let mapped = map_moments(jacobian.transpose(), moments_of_slope(slope));
            assert!((mapped.first - deformed).length() < 1e-6, "{} instead of {deformed}", mapped.first);
        }
    }

    /// The four corners of a cell match point samples on its triangles.
    #[test]
    fn corners_of_a_cell_are_its_triangles() {
        let mut random = Random(9);
        for _ in 0..200 {
            let h: [f64; 4] = std::array::from_fn(|_| random.unit()); // heights at (0,0), (1,0), (0,1), (1,1)
            let spacing = DVec2::new(0.3, 0.7);
            let corner = |i: usize| {
                let (sx, sy) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { 1.0 } else { -1.0 });
                moments_of_corner(DVec4::new(h[i], h[i ^ 1], h[i ^ 2], h[i ^ 3]), spacing * DVec2::new(sx, sy))
            };
            let at = |i: usize| DVec3::new((i & 1) as f64 * spacing.x, (i >> 1) as f64 * spacing.y, h[i]);
            let centre = 0.25 * (at(0) + at(1) + at(2) + at(3));
            let plane = |p: usize, q: usize| {
                let n = (at(q) - at(p)).cross(centre - at(p));
                -n.truncate() / n.z
            };
            // The samples are points on both sides of the diagonals of the cell.
            let mut quarters = [(); 4].map(|()| Vec::new());
            for k in 0..16 {
                let (column, row) = (f64::from(k % 4), f64::from(k / 4));
                let quarter = usize::from(column > 1.0) + 2 * usize::from(row > 1.0);
                for [u, v] in [[0.5, 0.25], [0.5, 0.75], [0.25, 0.5], [0.75, 0.5]] {
                    let (x, y) = (column + u - 2.0, row + v - 2.0);
                    let (below, left) = (y + x < 0.0, x < y);
                    quarters[quarter].push(match (below, left) {
                        (true, true) => plane(0, 2),
                        (true, false) => plane(0, 1),
                        (false, true) => plane(2, 3),
                        (false, false) => plane(1, 3),
                    });
                }
            }
            for (i, slopes) in quarters.into_iter().enumerate() {
                let error = distance(mean(slopes.into_iter()), corner(i));
                assert!(error < 1e-12, "corner {i}: {error}");
            }
        }
    }

    #[test]
    fn degenerate_normals_stay_finite() {
        for n in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(1e-30, 0.0, 1e-30), DVec3::splat(1e150)] {
            let m = moments_of_normal(n);
            assert!(
                m.first.is_finite() && m.second.is_finite() && m.first.length() <= MAX_SLOPE * (1.0 + 1e-12),
                "{n}"
            );
        }
        assert!(slope_of_heights(DVec4::new(0.0, 1.0, 0.0, 1.0), DVec2::ZERO).is_finite());
    }
}
