//! Represents slopes in unit-surface coordinates, rotated to the viewer's azimuth, for integrals and histograms of visible normals. In
//! these coordinates, all distributions of a family have the same shape. This code is independent of the library's own change of
//! coordinates.

#![allow(dead_code, reason = "each test binary uses its own part")]

use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;

/// A slope distribution seen by a viewer.
pub struct Seen<'a> {
    /// The slope distribution.
    pub distribution: &'a (dyn SlopeDistribution + Sync),
    /// The unit vector towards the viewer.
    pub wo: DVec3,
    /// The linear map from unit coordinates to slopes relative to the mean slope.
    factor: DMat2,
    /// Whether the unit surface is GGX.
    ggx: bool,
    /// The upper bound of the visible slopes along the first coordinate.
    pub nu: f64,
}

impl<'a> Seen<'a> {
    /// Creates a Gaussian surface with its viewer.
    pub fn beckmann(distribution: &'a Beckmann, wo: DVec3) -> Self {
        Self::new(distribution, wo, distribution.covariance(), false)
    }

    /// Creates a GGX surface with its viewer.
    pub fn ggx(distribution: &'a Ggx, wo: DVec3) -> Self {
        Self::new(distribution, wo, distribution.roughness(), true)
    }

    fn new(distribution: &'a (dyn SlopeDistribution + Sync), wo: DVec3, s: DVec3, ggx: bool) -> Self {
        let x = s.x.sqrt();
        let k = s.z / x;
        let factor = DMat2::from_cols(DVec2::new(x, k), DVec2::new(0.0, (s.y - k * k).sqrt()));
        let t = factor.transpose() * wo.xy();
        let e = t.try_normalize().unwrap_or(DVec2::X);
        let a = wo.z - wo.xy().dot(distribution.mean_slope());
        let nu = if t.length() > 0.0 { a / t.length() } else { f64::INFINITY };
        Self { distribution, wo, factor: factor * DMat2::from_cols(e, DVec2::new(-e.y, e.x)), ggx, nu }
    }

    /// Returns the normal at unit coordinates, and the solid angle per unit area of these coordinates.
    pub fn normal(&self, p: DVec2) -> (DVec3, f64) {
        let slope = self.distribution.mean_slope() + self.factor * p;
        let n = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
        (n, n.z.powi(3) * self.factor.determinant().abs())
    }

    /// Returns the unit coordinates of a normal.
    pub fn coordinates(&self, n: DVec3) -> DVec2 {
        self.factor.inverse() * (DVec2::new(-n.x, -n.y) / n.z - self.distribution.mean_slope())
    }

    /// Maps the square `[0, 1]²` to visible coordinates, and also returns the Jacobian. For every `ν`, points are dense where the density
    /// is large.
    pub fn from_square(&self, q: DVec2) -> (DVec2, f64) {
        if self.ggx {
            // With x = tan t and y = √(1 + x²) tan p, all terms are polynomials in sines and cosines.
            let low = -std::f64::consts::FRAC_PI_2;
            let width = self.nu.atan() - low;
            let (t, p) = (low + width * q.x, low * (1.0 - 2.0 * q.y));
            let root = 1.0 / t.cos();
            (DVec2::new(t.tan(), root * p.tan()), width * root.powi(3) * 2.0 * -low / p.cos().powi(2))
        } else {
            let (top, width) = self.extent();
            (DVec2::new(top - width * (1.0 - q.x), 8.0 * (2.0 * q.y - 1.0)), width * 16.0)
        }
    }

    /// Maps visible coordinates back to the square, and clamps the result to it.
    pub fn square_of(&self, p: DVec2) -> DVec2 {
        let q = if self.ggx {
            let low = -std::f64::consts::FRAC_PI_2;
            let across = (p.y / (1.0 + p.x * p.x).sqrt()).atan();
            DVec2::new((p.x.atan() - low) / (self.nu.atan() - low), 0.5 * (1.0 - across / low))
        } else {
            let (top, width) = self.extent();
            DVec2::new(1.0 - (top - p.x) / width, 0.5 * (p.y / 8.0 + 1.0))
        };
        q.clamp(DVec2::ZERO, DVec2::splat(1.0 - 1e-12))
    }

    /// Returns the upper end and the length of the visible range of a Gaussian.
    fn extent(&self) -> (f64, f64) {
        let top = self.nu.min(8.0);
        (top, if top > 0.0 { top + 8.0 } else { 40.0 / (5.0 - top) })
    }
}

/// Returns the unit direction at an angle from the normal and an azimuth, both in degrees.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

/// Returns surfaces that range from isotropic to a correlation of nearly one, with mean slopes of up to several times the roughness.
pub fn surfaces() -> Vec<(DVec2, DVec3)> {
    let mut all = Vec::new();
    for (x, y, r) in [
        (0.05f64, 0.05, 0.0),
        (0.5, 0.5, 0.0),
        (1.0, 0.3, 0.6),
        (0.2, 0.7, -0.95),
        (0.6, 0.5, 0.9998),
        (0.4, 0.4, -1.0),
        (1e-5, 0.3, 0.0),
        (3.0, 2.0, 0.3),
    ] {
        for m in [DVec2::ZERO, DVec2::new(0.4, -0.3), DVec2::new(-2.0, 1.0), DVec2::new(0.0, 6.0)] {
            all.push((m, DVec3::new(x * x, y * y, r * x * y)));
        }
    }
    all
}
