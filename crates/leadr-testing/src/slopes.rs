//! Slope distributions for BRDF tests, with integrals over all half vectors.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::quadrature::composite_gauss;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_cholesky};

/// A slope distribution, together with a square root of its covariance or roughness matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// The slope distribution, which is Gaussian or GGX.
    pub kind: Kind,
    /// The square root of the covariance or roughness matrix.
    pub root: DMat2,
}

/// A slope distribution of one of two kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A Gaussian distribution.
    Beckmann(Beckmann),
    /// A GGX distribution.
    Ggx(Ggx),
}

/// A constructor of [`Slopes`] from the mean, two standard deviations and the correlation.
pub type New = fn(DVec2, f64, f64, f64) -> Slopes;

impl Slopes {
    /// Creates Gaussian slopes of standard deviations `x`, `y` and correlation `r`.
    pub fn beckmann(mean: DVec2, x: f64, y: f64, r: f64) -> Self {
        let covariance = DVec3::new(x * x, y * y, r * x * y);
        Self { kind: Kind::Beckmann(Beckmann::new(mean, covariance)), root: root(covariance) }
    }

    /// Creates GGX slopes with roughness `√2 (x, y)` and correlation `r`.
    pub fn ggx(mean: DVec2, x: f64, y: f64, r: f64) -> Self {
        let roughness = 2.0 * DVec3::new(x * x, y * y, r * x * y);
        Self { kind: Kind::Ggx(Ggx::new(mean, roughness)), root: root(roughness) }
    }

    /// Returns the constructors of Gaussian and GGX slopes.
    pub fn all() -> [New; 2] {
        [Self::beckmann, Self::ggx]
    }
}

fn root(s: DVec3) -> DMat2 {
    let c = slope_cholesky(s);
    DMat2::from_cols(DVec2::new(c.x, c.y), DVec2::new(0.0, c.z))
}

impl SlopeDistribution for Slopes {
    fn p22(&self, slope: DVec2) -> f64 {
        match self.kind {
            Kind::Beckmann(d) => d.p22(slope),
            Kind::Ggx(d) => d.p22(slope),
        }
    }
    fn ndf(&self, wn: DVec3) -> f64 {
        match self.kind {
            Kind::Beckmann(d) => d.ndf(wn),
            Kind::Ggx(d) => d.ndf(wn),
        }
    }
    fn mean_slope(&self) -> DVec2 {
        match self.kind {
            Kind::Beckmann(d) => d.mean_slope(),
            Kind::Ggx(d) => d.mean_slope(),
        }
    }
    fn shape(&self) -> DVec3 {
        match self.kind {
            Kind::Beckmann(d) => d.shape(),
            Kind::Ggx(d) => d.shape(),
        }
    }
    fn visible_area(&self, w: DVec3) -> f64 {
        match self.kind {
            Kind::Beckmann(d) => d.visible_area(w),
            Kind::Ggx(d) => d.visible_area(w),
        }
    }
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        match self.kind {
            Kind::Beckmann(d) => d.sample_visible(wo, u),
            Kind::Ggx(d) => d.sample_visible(wo, u),
        }
    }
}

/// Returns the direction at the angle `degrees` from z, and at the azimuth in radians.
pub fn direction(degrees: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

/// Computes `∫ f(wi) dwi` over the sphere, for an `f` that has the lobe of the distribution. The quadrature is over the whitened slopes of
/// visible half vectors, in polar coordinates `m + C tan ψ (cos φ, sin φ)`. The coordinates end where facets face away from the viewer.
pub fn integrate_directions(slopes: &Slopes, wo: DVec3, panels: usize, f: impl Fn(DVec3) -> DVec3) -> DVec3 {
    let m = slopes.mean_slope();
    let towards = slopes.root.transpose() * wo.xy();
    let (a, b) = (slopes.meso_area(wo), towards.length());
    let azimuth = towards.y.atan2(towards.x);
    let determinant = slopes.root.determinant().abs();
    let mut sum = DVec3::ZERO;
    for (from, to) in [(-FRAC_PI_2, FRAC_PI_2), (FRAC_PI_2, 3.0 * FRAC_PI_2)] {
        for (phi, wp) in composite_gauss(from, to, panels, 8) {
            // A slope is visible if a − b r cos φ > 0.
            let slope = b * phi.cos();
            let edge = if slope == 0.0 { f64::INFINITY } else { a / slope };
            let (low, high) = match (slope > 0.0, a > 0.0) {
                (true, true) => (0.0, edge),
                (true, false) => continue,
                (false, true) => (0.0, f64::INFINITY),
                (false, false) => (edge, f64::INFINITY),
            };
            let (sin, cos) = (phi + azimuth).sin_cos();
            for (psi, ws) in composite_gauss(low.atan(), high.atan(), panels, 8) {
                let r = psi.tan();
                let h = normal_of_slope(m + slopes.root * (r * DVec2::new(cos, sin)));
                let cosine = wo.dot(h);
                if cosine <= 0.0 {
                    continue;
                }
                let wi = (2.0 * cosine * h - wo).normalize();
                let jacobian = 4.0 * cosine * h.z.powi(3) * determinant * r * (1.0 + r * r);
                sum += wp * ws * jacobian * f(wi);
            }
        }
    }
    sum
}

/// Returns the polar coordinates `(theta_h, phi)` of `wi` about `wo`, in `[0, π/2) × [0, 2π)`. `theta_h` is half the angle between `wi` and
/// `wo`. The solid angle is `dwi = 4 cos θ_h sin θ_h dθ_h dφ`.
pub fn polar_about(wo: DVec3, wi: DVec3) -> (f64, f64) {
    let frame = leadr_reflectance::frame::frame_about(wo);
    let w = leadr_reflectance::frame::to_frame(&frame, wi);
    let theta = 0.5 * (w.x * w.x + w.y * w.y).sqrt().atan2(w.z);
    (theta, w.y.atan2(w.x).rem_euclid(2.0 * PI))
}
