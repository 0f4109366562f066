//! Geometric specular antialiasing, which converts the surface's rotation within a pixel to roughness in slope space (Tokuyoshi & Kaplanyan
//! 2019, "IGSA", and its supplement).
//!
//! Within a pixel, the half vector changes in the tangent frame by its screen derivatives `Δx` and `Δy`. Under a Gaussian pixel filter of
//! variance [`PIXEL_VARIANCE`], this motion is a Gaussian kernel on the sphere with the covariance `σ² (Δx Δxᵀ + Δy Δyᵀ)`. The slope-space
//! Jacobian ([`sphere_to_slope_jacobian`], eq. 7) transforms the kernel to slopes. The kernel is added to the covariance of a Gaussian surface
//! ([`filter_covariance`]). Twice the kernel is added to the GGX roughness matrix ([`filter_roughness`]; `α² = 2σ²`).
//!
//! **With and without the light.** For a distant light and viewer, the half vector is constant and the frame rotates by the change `d` of
//! its normal. The slope `p` of the half vector then moves by `(I + p pᵀ) d`. At the pole, the kernel of the normal alone
//! (`slopes::statistics::add_macro_curvature`) therefore equals the kernel of the half vector. [`tilt_kernel`] transforms the kernel to any
//! other slope. Passes with a light transform the kernel to the slope of the half vector. Other passes use the mean slope, where the lobe
//! peaks.

use super::packing::principal_variances;
use super::statistics::{clamp_covariance, map_second_moments};
use crate::limits::{MIN_NORMAL_Z, at_least, within};
use glam::{DMat2, DVec2, DVec3};
use std::f64::consts::PI;

/// The variance of the pixel filter, in squared pixels, for a standard deviation of half a pixel.
pub const PIXEL_VARIANCE: f64 = 0.25;

/// The ratio of the kernel to the slope covariance at which the kernel's excess variance is halved ([`kernel_over`]).
pub const KERNEL_COVER: f64 = 3.0;

/// The bound of the kernel's trace, in radians². It is the paper's bound `α² ≤ 0.18` of an isotropic kernel, written in variances.
pub const KERNEL_BOUND: f64 = 0.18;

/// Returns the kernel in slope space, `(s_xx, s_yy, s_xy)`, at the unit half vector `wh` in the tangent frame. `dx` and `dy` are the
/// differences of `wh` to the neighbouring pixels.
///
/// The function bounds the kernel on the sphere, where the bound is an angle, and then transforms it to slopes, which grow without limit
/// towards the horizon. Let `wh'` be the component of a difference orthogonal to `wh`. The slope `p` then moves by
/// `−(p wh'.z + wh'.xy) / wh.z`. This is eq. 7 of the supplement times the inverse of eq. 4 ([`sphere_to_disk_jacobian`]), without their
/// division by `sin θ`.
pub fn half_vector_kernel(wh: DVec3, dx: DVec3, dy: DVec3) -> DVec3 {
    let across = |d: DVec3| {
        let d = d.map(|x| within(x, 1e3));
        d - wh * wh.dot(d)
    };
    let (dx, dy) = (across(dx), across(dy));
    let angle = PIXEL_VARIANCE * (dx.length_squared() + dy.length_squared());
    let scale = PIXEL_VARIANCE * (KERNEL_BOUND / at_least(angle, 1e-12)).min(1.0);
    let (u, v) = (slope_change(wh, dx), slope_change(wh, dy));
    clamp_covariance(scale * DVec3::new(u.x * u.x + v.x * v.x, u.y * u.y + v.y * v.y, u.x * u.y + v.x * v.y))
}

/// Returns the change of the slope of the unit half vector `wh` that moves by `d`, orthogonal to `wh`.
fn slope_change(wh: DVec3, d: DVec3) -> DVec2 {
    let z = wh.z.max(MIN_NORMAL_Z);
    let slope = -wh.truncate() / z;
    -(slope * d.z + d.truncate()) / z
}

/// Returns the unit vector along `h.xy`, which is x at the pole.
fn azimuth(h: DVec3) -> DVec2 {
    h.truncate().try_normalize().unwrap_or(DVec2::X)
}

/// Returns the Jacobian of the projection of the sphere to the unit disk, at the unit half vector `h` (supplement, eq. 4). It maps the
/// angles along the meridian and along the parallel of `h` to changes of `h.xy`:
///
/// ```text
/// [hx hz  −hy]
/// [hy hz   hx] / √(1 − hz²)
/// ```
///
/// At the pole, the meridian is the one along x.
pub fn sphere_to_disk_jacobian(h: DVec3) -> DMat2 {
    let along = azimuth(h);
    DMat2::from_cols(h.z * along, along.perp())
}

/// Returns the Jacobian of the map from the unit disk to slopes, at the unit half vector `h` (supplement, eq. 6). It maps changes of `h.xy`
/// to changes of the slope `−h.xy / h.z`:
///
/// ```text
/// [1 − hy²  hx hy  ]
/// [hx hy    1 − hx²] / (−hz³)
/// ```
pub fn disk_to_slope_jacobian(h: DVec3) -> DMat2 {
    let z = h.z.max(MIN_NORMAL_Z);
    DMat2::from_cols(DVec2::new(1.0 - h.y * h.y, h.x * h.y), DVec2::new(h.x * h.y, 1.0 - h.x * h.x)) * -z.powi(-3)
}

/// Returns the Jacobian of the map from the sphere to slopes, at the unit half vector `h` (supplement, eq. 7). It maps the angles of
/// [`sphere_to_disk_jacobian`] to changes of the slope, and equals [`disk_to_slope_jacobian`] times [`sphere_to_disk_jacobian`]:
///
/// ```text
/// [hx  −hy hz]
/// [hy   hx hz] / (−hz² √(1 − hz²))
/// ```
pub fn sphere_to_slope_jacobian(h: DVec3) -> DMat2 {
    let (along, z) = (azimuth(h), h.z.max(MIN_NORMAL_Z));
    DMat2::from_cols(along, z * along.perp()) * -z.powi(-2)
}

/// Transforms the kernel of the normal, `(s_xx, s_yy, s_xy)` at slope 0, to the slope `p`. The result is `(I + p pᵀ) K (I + p pᵀ)`.
///
/// The Jacobian is the first term of the series of `tan(θ + ψ)`, and the next term is `ψ tan θ` times the first. The kernel is scaled down
/// where the next term exceeds half of the first. The slope spread therefore stays below half the slope, and never crosses the pole.
pub fn tilt_kernel(kernel: DVec3, slope: DVec2) -> DVec3 {
    let (x, y, c) = (1.0 + slope.x * slope.x, 1.0 + slope.y * slope.y, slope.x * slope.y);
    let second_order = slope.x * slope.x * kernel.x + slope.y * slope.y * kernel.y + 2.0 * c * kernel.z;
    let kernel = kernel * (0.25 / second_order.max(1e-12)).min(1.0);
    clamp_covariance(map_second_moments(DMat2::from_cols_array(&[x, c, c, y]), kernel))
}

/// Returns the kernel variance to add to slopes of covariance `s`.
///
/// A kernel of variance 1/4 prevents subpixel flicker, but a pixel is a box of variance 1/12. Over slopes that are too rough to flicker,
/// the wider kernel only blurs. With `T` = [`KERNEL_COVER`]` S` the result is
///
/// ```text
/// K − ⅔ (K⁻¹ + T⁻¹)⁻¹,   (K⁻¹ + T⁻¹)⁻¹ = (|T| K + |K| T) / |K + T|
/// ```
///
/// The result is `K` over smooth slopes, and tends to `K/3` over rough slopes. The variances of slopes and kernel add up to at least 0.235
/// squared pixels in every direction.
pub fn kernel_over(kernel: DVec3, s: DVec3) -> DVec3 {
    let t = KERNEL_COVER * s;
    let (of_kernel, of_slopes) = (determinant(kernel), determinant(t));
    let per = 1.0 / determinant(kernel + t).max(of_kernel + of_slopes).max(1e-30);
    kernel - (2.0 / 3.0 * per) * (of_slopes * kernel + of_kernel * t)
}

/// Returns an axis-aligned kernel that is at least as wide as `kernel` in every direction. The off-diagonal magnitude is added to both
/// variances.
pub fn axis_aligned_kernel(kernel: DVec3) -> DVec3 {
    DVec3::new(kernel.x + kernel.z.abs(), kernel.y + kernel.z.abs(), 0.0)
}

/// Returns the narrowest isotropic kernel that is at least as wide as `kernel` in every direction. Its variance is the larger principal
/// variance of `kernel`.
pub fn isotropic_kernel(kernel: DVec3) -> DVec3 {
    let variance = principal_variances(kernel).x;
    DVec3::new(variance, variance, 0.0)
}

/// Raises the matrix determinant to at least `tau` by changing only the off-diagonal element. This restores the determinant that rounding
/// loses in sums of elongated matrices. In exact arithmetic, `|A + K| ≥ |A|` always holds (Minkowski). Unlike the supplement's clamp inside
/// `D`, this clamp leaves the distribution normalised. The clamp works for every distribution.
pub fn clamp_determinant(a: DVec3, tau: f64) -> DVec3 {
    let c = at_least(a.x * a.y - tau, 0.0).sqrt();
    DVec3::new(a.x, a.y, within(a.z, c))
}

/// Returns the determinant of a covariance or roughness matrix, at least 0.
fn determinant(a: DVec3) -> f64 {
    (a.x * a.y - a.z * a.z).max(0.0)
}

/// Returns the covariance `S + K` of a Gaussian surface (LEADR, Beckmann) under the kernel, with a determinant of at least `|S|`.
pub fn filter_covariance(s: DVec3, kernel: DVec3) -> DVec3 {
    clamp_determinant(s + kernel, determinant(s))
}

/// Returns the GGX roughness matrix `A + 2K` under the kernel, with a determinant of at least `|A|` (IGSA: `τ = αx² αy²`).
pub fn filter_roughness(a: DVec3, kernel: DVec3) -> DVec3 {
    clamp_determinant(a + 2.0 * kernel, determinant(a))
}

/// Returns the GGX density `D(wh)` with a mean slope and the determinant clamp of the supplement, section 1:
/// `1 / (π √|A| (d A⁻¹ dᵀ + z²)²)` with `d = wh.xy + wh.z m`. In both places, `|A|` is clamped to at least `tau` > 0. The density is 0 for
/// `wh.z ≤ 0`.
pub fn ggx_ndf_clamped(wh: DVec3, m: DVec2, a: DVec3, tau: f64) -> f64 {
    if wh.z <= 0.0 {
        return 0.0;
    }
    let det = (a.x * a.y - a.z * a.z).max(tau.max(1e-16));
    let d = wh.truncate() + wh.z * m;
    let q = (a.y * d.x * d.x + a.x * d.y * d.y - 2.0 * a.z * d.x * d.y).max(0.0) / det;
    let g = 1.0 / (q + wh.z * wh.z).max(1e-13);
    g * g / (PI * det.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::beckmann_p22;
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::normal_of_slope;
    use crate::slopes::statistics::add_macro_curvature;
    use glam::{DMat2, DQuat};

    /// Half vectors near the pole, near the horizon and between.
    fn half_vectors() -> [DVec3; 5] {
        let of = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
        [of(0.3, -0.5, 0.8), of(-0.9, 0.1, 0.2), of(1e-3, 2e-3, 1.0), of(0.0, -0.4, 0.3), DVec3::Z]
    }

    /// Returns the tangents along the meridian and along the parallel of `h` (supplement, eq. 3).
    fn tangents(h: DVec3) -> [DVec3; 2] {
        let (sin, along) = (h.truncate().length(), azimuth(h));
        [(h.z * along).extend(-sin), along.perp().extend(0.0)]
    }

    fn assert_equal(found: DMat2, expected: DMat2, tolerance: f64) {
        let error = (found - expected).to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
        let size = expected.to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
        assert!(error < tolerance * size, "{found} instead of {expected}");
    }

    #[test]
    fn jacobians_are_finite_differences() {
        const STEP: f64 = 1e-6;
        let slope = |h: DVec3| -h.truncate() / h.z;
        // The height of a point of the disk follows from its position.
        let slope_on_disk = |p: DVec2| -p / (1.0 - p.length_squared()).sqrt();
        let central = |at: &dyn Fn(f64) -> DVec2| (at(STEP) - at(-STEP)) / (2.0 * STEP);
        for h in half_vectors() {
            // Eq. 1 to 3: an angle rotates the half vector towards a tangent.
            let moved = |tangent: DVec3, angle: f64| h * angle.cos() + tangent * angle.sin();
            let [to_disk, to_slope] = [(|h: DVec3| h.truncate()) as fn(DVec3) -> DVec2, slope].map(|of| {
                let [x, y] = tangents(h).map(|tangent| central(&|angle| of(moved(tangent, angle))));
                DMat2::from_cols(x, y)
            });
            assert_equal(sphere_to_disk_jacobian(h), to_disk, 1e-8);
            assert_equal(sphere_to_slope_jacobian(h), to_slope, 1e-7);
            let [x, y] = DMat2::IDENTITY
                .to_cols_array_2d()
                .map(|axis| central(&|step| slope_on_disk(h.truncate() + step * DVec2::from_array(axis))));
            assert_equal(disk_to_slope_jacobian(h), DMat2::from_cols(x, y), 1e-7);
        }
    }

    #[test]
    fn the_product_of_the_jacobians_is_the_change_of_the_kernel() {
        for h in half_vectors() {
            let product = disk_to_slope_jacobian(h) * sphere_to_disk_jacobian(h);
            assert_equal(sphere_to_slope_jacobian(h), product, 1e-12);
            let [x, y] = tangents(h);
            assert_equal(DMat2::from_cols(slope_change(h, x), slope_change(h, y)), product, 1e-12);
            // Without angles, the kernel has eq. 7 times the inverse of eq. 4, which is eq. 6.
            let of_disk = sphere_to_slope_jacobian(h) * sphere_to_disk_jacobian(h).inverse();
            let d = 0.3 * x - 0.7 * y;
            let error = slope_change(h, d) - of_disk * d.truncate();
            assert!(error.length() < 1e-12 * slope_change(h, d).length(), "{h}: {error}");
        }
    }

    #[test]
    fn is_the_supplements_jacobian() {
        for h in half_vectors() {
            let [along, across] = tangents(h);
            let (a, b) = (DVec2::new(0.02, -0.01), DVec2::new(0.005, 0.03));
            let kernel = half_vector_kernel(h, along * a.x + across * a.y, along * b.x + across * b.y);
            let jacobian = sphere_to_slope_jacobian(h);
            let (u, v) = (jacobian * a, jacobian * b);
            let expected = 0.25 * DVec3::new(u.x * u.x + v.x * v.x, u.y * u.y + v.y * v.y, u.x * u.y + v.x * v.y);
            assert!((kernel - expected).length() < 1e-9 * expected.length(), "{kernel} instead of {expected}");
        }
    }

    /// If the frame rotates under a constant half vector, the kernel from tangent-frame differences equals the tilted kernel of the normal.
    #[test]
    fn the_normals_kernel_tilts_into_the_half_vectors() {
        for wh in [DVec3::Z, DVec3::new(0.4, 0.2, 0.9).normalize(), DVec3::new(-0.8, 0.3, 0.5).normalize()] {
            // Rotating the frame about z × d moves its normal by d and rotates the half vector in the frame the opposite way.
            let moved = |d: DVec2| DQuat::from_scaled_axis(DVec3::new(d.y, -d.x, 0.0)) * wh - wh;
            let (dx, dy) = (DVec2::new(1e-5, 3e-6), DVec2::new(-2e-6, 2e-5));
            let from_half_vector = half_vector_kernel(wh, moved(dx), moved(dy));
            // The slopes of a normal have the opposite sign of its x and y. Flipping the signs of both differences has no effect.
            let normal = add_macro_curvature(DVec3::ZERO, -dx, -dy);
            let tilted = tilt_kernel(normal, -wh.truncate() / wh.z);
            assert!((tilted - from_half_vector).length() < 1e-4 * tilted.length(), "{tilted} {from_half_vector}");
        }
    }

    #[test]
    fn cheaper_kernels_exceed_the_full_one_along_every_direction() {
        let mut tight = 0.0f64;
        for i in 0..500 {
            let f = f64::from(i);
            let (u, v) = (DVec2::from_angle(1.7 * f) * (0.3 * f).sin(), DVec2::from_angle(0.9 * f) * (0.7 * f).cos());
            let kernel = add_macro_curvature(DVec3::ZERO, 0.3 * u, 0.3 * v);
            for cheap in [axis_aligned_kernel(kernel), isotropic_kernel(kernel)] {
                let mut least = f64::MAX;
                for k in 0..64 {
                    let d = DVec2::from_angle(PI * f64::from(k) / 64.0);
                    let along = |s: DVec3| d.x * d.x * s.x + d.y * d.y * s.y + 2.0 * d.x * d.y * s.z;
                    assert!(along(cheap) >= along(kernel) * (1.0 - 1e-12));
                    least = least.min(along(cheap) / along(kernel).max(1e-12));
                }
                tight = tight.max(least);
            }
        }
        assert!(tight < 1.5, "the bounds must be tight in some direction");
    }

    #[test]
    fn the_kernel_is_as_wide_as_it_has_to_be() {
        // All variances are in squared pixels.
        let round = |v: f64| DVec3::new(v, v, 0.0);
        assert_eq!(kernel_over(round(0.25), round(0.0)), round(0.25));
        assert!((kernel_over(round(0.25), round(100.0)).x - 1.0 / 12.0).abs() < 1e-3);
        let least = (0..1000).map(|i| 1e-3 * f64::from(i)).map(|s| s + kernel_over(round(0.25), round(s)).x);
        assert!((least.fold(f64::MAX, f64::min) - 0.2357).abs() < 1e-4);
        // The function treats the two axes independently, even for a one-dimensional kernel.
        let each = kernel_over(DVec3::new(0.25, 0.1, 0.0), DVec3::new(0.02, 3.0, 0.0));
        assert!((each.x - kernel_over(round(0.25), round(0.02)).x).abs() < 1e-12);
        assert!((each.y - kernel_over(round(0.1), round(3.0)).y).abs() < 1e-12);
        let long = kernel_over(DVec3::new(0.25, 0.0, 0.0), round(0.02));
        assert!((long.x - each.x).abs() < 1e-12 && long.y == 0.0);
    }

    #[test]
    fn determinant_never_shrinks() {
        for i in 0..2000 {
            let f = f64::from(i);
            // In 32 bits, rounding destroys the determinant of a long thin kernel on a smooth base.
            let base = 1e-6;
            let k = f64::from((0.3 * (0.1 * f).cos()) as f32);
            let l = f64::from((0.3 * (0.1 * f).sin()) as f32);
            let kernel = DVec3::new(f64::from((k * k) as f32), f64::from((l * l) as f32), f64::from((k * l) as f32));
            let s = DVec3::new(base, base, 0.0);
            for filtered in [filter_covariance(s, kernel), filter_roughness(s, kernel)] {
                assert!(filtered.x * filtered.y - filtered.z * filtered.z >= base * base * (1.0 - 1e-3));
            }
        }
        let a = DVec3::new(0.3, 0.2, 0.1);
        assert_eq!(clamp_determinant(a, 0.01), a);
    }

    #[test]
    fn clamped_ggx_is_normalised_and_held() {
        // The projected areas sum to one: ∫ D wh.z dwh = 1.
        let (m, a) =
            (DVec2::new(0.4, -0.2), filter_roughness(DVec3::new(0.05, 0.02, 0.01), DVec3::new(0.03, 0.05, -0.03)));
        let mut sum = 0.0;
        for (theta, wt) in composite_gauss(0.0, 0.5 * PI, 24, 8) {
            for (phi, wp) in composite_gauss(0.0, 2.0 * PI, 24, 8) {
                let wh = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                sum += wt * wp * theta.sin() * theta.cos() * ggx_ndf_clamped(wh, m, a, 1e-4);
            }
        }
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        let peak = ggx_ndf_clamped(DVec3::Z, DVec2::ZERO, DVec3::new(1.0, 1.0, 1.0), 1e-4);
        assert!((peak - 100.0 / PI).abs() < 1e-9);
    }

    /// Compares two lobes of a Gaussian surface on a rotating frame: the average over the pixel, and the lobe widened by the kernel.
    #[test]
    fn against_the_exact_mean_over_a_curved_pixel() {
        let forms = ["none", "normal", "normal at the mean slope", "half vector"];
        println!("relative L1 error of the lobe over half vectors, per kernel ({forms:?})");
        let mut worst = [0.0f64; 4];
        for (alpha, angle, m) in [
            (0.05, 0.05, DVec2::ZERO),
            (0.05, 0.2, DVec2::ZERO),
            (0.2, 0.4, DVec2::ZERO),
            (0.05, 0.05, DVec2::new(0.8, 0.3)),
            (0.05, 0.2, DVec2::new(0.8, 0.3)),
            (0.2, 0.2, DVec2::new(1.5, 0.0)),
        ] {
            let s = DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0);
            let d = DVec2::new(0.8, 0.6) * angle;
            let kernel = add_macro_curvature(DVec3::ZERO, d, DVec2::ZERO);
            let tilted = tilt_kernel(kernel, m);
            let reach = 5.0 * (s + tilted).truncate().max_element().sqrt();
            let (mut error, mut total) = ([0.0; 4], 0.0);
            for (u, wu) in composite_gauss(-reach, reach, 30, 4) {
                for (v, wv) in composite_gauss(-reach, reach, 30, 4) {
                    let slope = m + DVec2::new(u, v);
                    let wh = normal_of_slope(slope);
                    // The slope densities are in the measure of the untilted frame, with D = P22 / z⁴ on the sphere.
                    let exact: f64 = composite_gauss(-3.0, 3.0, 24, 4)
                        .into_iter()
                        .map(|(t, w)| {
                            let rotated = DQuat::from_scaled_axis(DVec3::new(d.y, -d.x, 0.0) * t) * wh;
                            let p = beckmann_p22(-rotated.truncate() / rotated.z, m, s) / rotated.z.powi(4);
                            w * (-2.0 * t * t).exp() * (2.0 / PI).sqrt() * if rotated.z > 0.0 { p } else { 0.0 }
                        })
                        .sum();
                    let z4 = wh.z.powi(4);
                    let kernels = [DVec3::ZERO, kernel, tilted, tilt_kernel(kernel, slope)];
                    // The solid angle of the slope cell includes the factor z³.
                    let w = wu * wv * wh.z.powi(3);
                    for (e, k) in error.iter_mut().zip(kernels) {
                        *e += w * (beckmann_p22(slope, m, filter_covariance(s, k)) / z4 - exact).abs();
                    }
                    total += w * exact;
                }
            }
            let relative = error.map(|e| e / total);
            for (w, r) in worst.iter_mut().zip(relative) {
                *w = w.max(r);
            }
            println!("alpha {alpha}, {angle} rad per pixel, mean slope {m}: {relative:.3?}");
        }
        println!("worst: {worst:.3?}");
        assert!(worst[2] < 0.5 * worst[0] && worst[2] < 0.6 * worst[1], "{worst:?}");
    }

    #[test]
    fn finite_everywhere() {
        for wh in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 0.0, 1e-30), DVec3::Z] {
            for d in [DVec3::ZERO, DVec3::splat(1e30), DVec3::new(-2.0, 0.0, 1.0)] {
                let k = half_vector_kernel(wh, d, -d);
                assert!(k.is_finite() && tilt_kernel(k, DVec2::splat(70.0)).is_finite());
                assert!(filter_roughness(DVec3::ZERO, k).is_finite());
                assert!(ggx_ndf_clamped(wh, DVec2::new(1e6, 0.0), k, 0.0).is_finite());
            }
        }
    }
}
