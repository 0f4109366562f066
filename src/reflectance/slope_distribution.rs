//! What microfacet theory asks of a distribution of slopes.

use super::limits::{MIN_AREA, MIN_NORMAL_Z};
use glam::{DVec2, DVec3};

/// A distribution of slopes with everything microfacet theory asks of it. Directions in the tangent frame, z up.
pub trait SlopeDistribution {
    /// Density of slopes, P22(slope).
    fn p22(&self, slope: DVec2) -> f64;
    /// D(wn) = P22 / wn.z^4; 0 for wn.z <= 0.
    fn ndf(&self, wn: DVec3) -> f64 {
        if wn.z <= 0.0 {
            return 0.0;
        }
        let z = wn.z.max(MIN_NORMAL_Z);
        self.p22(DVec2::new(-wn.x / z, -wn.y / z)) / z.powi(4)
    }
    /// Mean slope.
    fn mean_slope(&self) -> DVec2;
    /// Visible projected area A(w) >= max(a(w), 0): integral of max(0, w·(-x,-y,1)) P22.
    fn visible_area(&self, w: DVec3) -> f64;
    /// a(w) = w.z - w.xy·mean: the mesosurface's projected area.
    fn meso_area(&self, w: DVec3) -> f64 {
        super::projected_area::meso_area(w, self.mean_slope())
    }
    /// Density of visible normals, max(0, wo·wn) D(wn) / A(wo).
    fn vndf(&self, wo: DVec3, wn: DVec3) -> f64 {
        wo.dot(wn).max(0.0) * self.ndf(wn) / self.visible_area(wo).max(MIN_AREA)
    }
    /// A visible normal for u in [0,1)^2; exact.
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3;
}
