//! Exact sampling of visible normals of a noncentral anisotropic GGX surface, by spherical caps (Dupuy & Benyoub 2023), for viewers above
//! and below the mesosurface.
//!
//! The affine map `slope = m + C s`, `C Cᵀ = A`, relates the surface to the standard surface. A facet has the projected area `a − t·s`
//! towards the viewer, with `t = Cᵀ wo.xy`. Up to a constant factor, this area equals the facet's projected area on the standard surface in
//! the direction `o = (t, a) / √(b² + a²)`.
//!
//! Spherical caps also work for viewers below the horizon. Normals of the standard surface are uniform over the upper hemisphere
//! (`D = 1/π`), so visible normals have the density `(o·h) / (π A)`, `A = (1 + o.z) / 2`, on `h.z > 0, o·h > 0`. The reflection
//! `i = 2 (o·h) h − o` has the Jacobian `4 (o·h)`, so `i` is uniform with the density `1 / (2π (1 + o.z))`. Since `i + o = 2 (o·h) h`, the
//! condition `h.z > 0` equals `i.z > −o.z`, which is a spherical cap for either sign of `o.z`. The sampler draws `i` uniformly in that cap
//! and normalises `h = i + o`.

use super::projected_area::meso_area;
use crate::roots::bisect;
use crate::slopes::grid::slope_cholesky;
use crate::slopes::statistics::with_least_variance;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Samples a visible normal from `u` in `[0, 1)²`. The density is `max(0, wo·wn) D(wn) / A(wo)` for the [`ggx_ndf`](super::ggx::ggx_ndf)
/// with the same mean slope and roughness matrix.
///
/// The azimuth of `i` relative to the viewer's azimuth is `φ = 2π u.y`. The sum `i + o` would cancel opposite the viewer
/// (`u.x → 1, u.y → ½`). The sum is computed without cancellation from `sin²θ_o − sin²θ_i = (i.z − o.z)(i.z + o.z)` and
/// `1 + cos φ = 2 cos²(φ/2)`. A viewer exactly opposite the displacement direction sees no facets and gets an arbitrary finite normal.
pub fn ggx_sample_visible(wo: DVec3, u: DVec2, m: DVec2, a: DVec3) -> DVec3 {
    let u = DVec2::new(u.x.clamp(0.0, 1.0 - 1.0 / 16_777_216.0), u.y);
    let c = slope_cholesky(with_least_variance(a));
    let t = DVec2::new(c.x * wo.x + c.y * wo.y, c.z * wo.y);
    let (meso, b) = (meso_area(wo, m), t.length());
    let e = if b > 1e-18 { t / b } else { DVec2::X };
    let length = meso.hypot(b).max(1e-18);
    // Compute 1 + o.z and 1 − o.z, each without cancellation.
    let (cosine, sine) = (meso / length, b / length);
    let above = if meso > 0.0 { 1.0 + cosine } else { sine * (b / (length - meso)) }.max(1e-12);
    let below = if meso > 0.0 { sine * (b / (length + meso)) } else { 1.0 - cosine };
    // From h.z = i.z + o.z and 1 − i.z = u.x (1 + o.z) follow 1 + i.z = h.z + (1 − o.z) and i.z − o.z = (1 − o.z) − u.x (1 + o.z).
    let height = (1.0 - u.x) * above;
    let sine_i = (u.x * above * (height + below)).sqrt();
    let (half_cos, half_sin) = (PI * (0.5 - u.y)).sin_cos();
    let along = height * (below - u.x * above) / (sine + sine_i).max(1e-18) + 2.0 * sine_i * half_cos * half_cos;
    let across = 2.0 * sine_i * half_sin * half_cos;
    let h = e.rotate(DVec2::new(along, across));
    // The normal is the slope m + C (−h / h.z), times −h.z.
    let n = DVec2::new(c.x * h.x, c.y * h.x + c.z * h.y) - m * height;
    n.extend(height).normalize()
}

/// Returns the probability that the slope across the viewer is at most `y`, for facets of the standard GGX surface (`α = 1`) whose slope along
/// the viewer is `x`: `F3` of thesis Table 2.V. The viewer sees the same share of all these facets, so it does not matter here. The
/// renderer samples by [`ggx_sample_visible`].
///
/// With `σ² = 1 + x²` and `tan t = y/σ`, the density `2σ³ / π(σ² + y²)²` has the integral `½ + (t + sin t cos t)/π`.
pub fn ggx_conditional_cdf(y: f64, x: f64) -> f64 {
    let t = (y / 1.0f64.hypot(x)).atan();
    0.5 + (t + t.sin() * t.cos()) / PI
}

/// Returns the slope `y` whose [`ggx_conditional_cdf`] is `u`, which is in `(0, 1)`: `Q3` of thesis Table 2.V.
pub fn ggx_conditional_quantile(u: f64, x: f64) -> f64 {
    let wanted = PI * (u - 0.5);
    let t = bisect(-FRAC_PI_2, FRAC_PI_2, 60, |t| t + t.sin() * t.cos() < wanted);
    1.0f64.hypot(x) * t.tan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::ggx::Ggx;
    use crate::facets::slope_distribution::SlopeDistribution;

    #[test]
    fn conditional_slopes_have_their_distribution() {
        let ggx = Ggx::isotropic(DVec2::ZERO, 1.0);
        for x in [0.0f64, 0.7, -3.0] {
            // Sums of the density over the angle of y.
            let sum = |until: f64| {
                let n = 20_000;
                let end = until.atan();
                let step = (end + FRAC_PI_2) / f64::from(n);
                let at = |i: i32| {
                    let t = -FRAC_PI_2 + step * (f64::from(i) + 0.5);
                    ggx.p22(DVec2::new(x, t.tan())) * step / (t.cos() * t.cos())
                };
                (0..n).map(at).sum::<f64>()
            };
            let all = sum(1e12);
            for y in [-4.0, -0.3, 0.0, 1.5, 20.0] {
                let cdf = ggx_conditional_cdf(y, x);
                assert!((cdf - sum(y) / all).abs() < 1e-6, "{x} {y}: {cdf} {}", sum(y) / all);
                assert!((ggx_conditional_quantile(cdf, x) - y).abs() < 1e-6 * (1.0 + y * y), "{x} {y}");
            }
        }
    }

    /// Compares the sampler with the direct sum `i + o`, in cases where the sum does not cancel.
    #[test]
    fn the_half_vector_of_a_uniform_cap() {
        for (o, u) in [
            (DVec3::new(0.6, 0.0, 0.8), DVec2::new(0.3, 0.1)),
            (DVec3::new(-0.48, 0.64, -0.6), DVec2::new(0.7, 0.8)),
            (DVec3::new(0.0, 1.0, 0.0), DVec2::new(0.95, 0.45)),
        ] {
            let z = (1.0 - u.x) * (1.0 + o.z) - o.z;
            let phi = 2.0 * PI * u.y + o.y.atan2(o.x);
            let r = (1.0 - z * z).sqrt();
            let want = (DVec3::new(r * phi.cos(), r * phi.sin(), z) + o).normalize();
            let got = ggx_sample_visible(o, u, DVec2::ZERO, DVec3::new(1.0, 1.0, 0.0));
            assert!((got - want).length() < 1e-14, "{got} {want}");
        }
    }

    #[test]
    fn samples_are_visible_unit_normals() {
        for m in [DVec2::ZERO, DVec2::new(3.0, -1.0)] {
            for a in [DVec3::ZERO, DVec3::new(0.3, 0.1, 0.1), DVec3::new(1.0, 1.0, 1.0)] {
                for degrees in [0.0f64, 40.0, 89.0, 120.0] {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let wo = DVec3::new(-0.6 * sin, 0.8 * sin, cos);
                    for i in 0..100 {
                        let u = DVec2::new(f64::from(i) / 100.0, (0.618 * f64::from(i)).fract());
                        let wn = ggx_sample_visible(wo, u, m, a);
                        assert!((wn.length() - 1.0).abs() < 1e-14 && wn.z > 0.0);
                        assert!(wo.dot(wn) > -1e-6, "{wn} for {wo} {m} {a}");
                    }
                }
            }
        }
        assert!(ggx_sample_visible(DVec3::NEG_Z, DVec2::ZERO, DVec2::ZERO, DVec3::ZERO).is_finite());
    }
}
