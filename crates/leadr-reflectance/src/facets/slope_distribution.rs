//! The interface of slope distributions in microfacet theory (thesis 2.1–2.3 and 3.2).

use crate::limits::{MIN_NORMAL_Z, at_least};
use glam::{DVec2, DVec3};

/// A slope distribution that provides all functions of microfacet theory. Directions are in the tangent frame, with z up.
///
/// [`Beckmann`](super::beckmann::Beckmann) and [`Ggx`](super::ggx::Ggx) implement the trait for noncentral anisotropic surfaces.
pub trait SlopeDistribution {
    /// Returns the slope density `P22(slope)`.
    fn p22(&self, slope: DVec2) -> f64;

    /// Returns the normal density `D(wn) = P22 / wn.z⁴` per unit of macrosurface and solid angle. The density is 0 for `wn.z ≤ 0`.
    fn ndf(&self, wn: DVec3) -> f64 {
        if wn.z <= 0.0 {
            return 0.0;
        }
        let z = wn.z.max(MIN_NORMAL_Z);
        self.p22(DVec2::new(-wn.x / z, -wn.y / z)) / z.powi(4)
    }

    /// Returns the mean slope.
    fn mean_slope(&self) -> DVec2;

    /// Returns the slope covariance `(xx, yy, xy)` or any multiple of it. If no covariance exists, the result is the roughness matrix.
    fn shape(&self) -> DVec3;

    /// Returns the visible projected area `A(w) ≥ max(a(w), 0)`, the integral of `max(0, w·(−x, −y, 1)) P22`.
    fn visible_area(&self, w: DVec3) -> f64;

    /// Returns the mesosurface's projected area, `a(w) = w.z − w.xy·mean`.
    fn meso_area(&self, w: DVec3) -> f64 {
        super::projected_area::meso_area(w, self.mean_slope())
    }

    /// Returns the density of visible normals, `max(0, wo·wn) D(wn) / A(wo)` (thesis eq. 2.17).
    fn vndf(&self, wo: DVec3, wn: DVec3) -> f64 {
        visible_density(wo, wn, self.ndf(wn), self.visible_area(wo))
    }

    /// Samples a visible normal exactly from `u` in `[0, 1)²`.
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3;
}

/// Returns `max(0, wo·wn) d / area`, at most 1e37. An `area` below 1e-26 counts as 1e-26. (The BRDF's bound
/// [`MIN_AREA`](crate::limits::MIN_AREA) would break the normalisation where only the far tail is visible.)
pub fn visible_density(wo: DVec3, wn: DVec3, d: f64, area: f64) -> f64 {
    let ratio = wo.dot(wn).max(0.0) / at_least(area, 1e-26);
    ratio * d.min(1e37 / ratio.max(1.0))
}
