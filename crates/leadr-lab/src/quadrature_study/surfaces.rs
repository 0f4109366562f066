//! Generates random surfaces and viewers.

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::projected_area::{meso_area, slope_spread};
use leadr_reflectance::random::Random;
use std::f64::consts::TAU;

/// A viewer and Gaussian slopes, in the tangent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The unit vector to the viewer.
    pub wo: DVec3,
    /// The mean slope.
    pub m: DVec2,
    /// The slope covariance `(s_xx, s_yy, s_xy)`.
    pub s: DVec3,
}

impl Surface {
    /// Returns the larger of the two slope standard deviations.
    pub fn roughness(&self) -> f64 {
        self.s.x.max(self.s.y).sqrt()
    }
}

/// Returns the direction at polar angle `theta` and azimuth `phi`, in radians.
pub fn spherical(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Returns random surfaces. Viewers are up to 85° from the displacement direction, deviations are log-uniform in .01–2,
/// correlations are within ±.9, and mean slopes are in the unit disc. The mesosurface faces the viewer with a projected area
/// above .01.
pub fn surfaces(n: usize, seed: u64) -> Vec<Surface> {
    let mut r = Random(seed);
    let mut out = Vec::with_capacity(n);
    while out.len() < n {
        let wo = spherical(r.range(0.0, 85f64.to_radians()), r.range(0.0, TAU));
        let (x, y, c) = (r.log(0.01, 2.0), r.log(0.01, 2.0), r.range(-0.9, 0.9));
        let m = DVec2::new(r.range(-1.0, 1.0), r.range(-1.0, 1.0));
        if m.length() <= 1.0 && wo.z - wo.x * m.x - wo.y * m.y > 0.01 {
            out.push(Surface { wo, m, s: DVec3::new(x * x, y * y, c * x * y) });
        }
    }
    out
}

/// Returns surfaces with wide lobes. Viewers are distributed like the pixels of a sphere, up to 83°. The larger deviation is
/// log-uniform in .4–2, and the smaller is .15–1 times as large. Of every ten surfaces, four are isotropic, three are
/// axis-aligned, and three have correlations up to ±.7. Half of the mean slopes are 0, and the other half are up to .7 per
/// axis.
pub fn rough_surfaces(n: usize, seed: u64) -> Vec<Surface> {
    let mut r = Random(seed);
    let mut out = Vec::with_capacity(n);
    while out.len() < n {
        let wo = spherical(r.unit().sqrt().asin().min(1.45), r.range(0.0, TAU));
        let (large, ratio) = (r.log(0.4, 2.0), r.log(0.15, 1.0));
        let small = if r.unit() < 0.4 { large } else { ratio * large };
        let (x, y) = if r.unit() < 0.5 { (small, large) } else { (large, small) };
        let c = if r.unit() < 0.5 || x == y { 0.0 } else { r.range(-0.7, 0.7) };
        let m = DVec2::new(r.range(-0.7, 0.7), r.range(-0.7, 0.7)) * if r.unit() < 0.5 { 0.0 } else { 1.0 };
        if meso_area(wo, m) > 0.05 {
            out.push(Surface { wo, m, s: DVec3::new(x * x, y * y, c * x * y) });
        }
    }
    out
}

/// Returns surfaces with viewers up to 88°, log-uniform deviations in .01–2.5, correlations within ±.95, and mean slopes up
/// to 4 in any direction. The mesosurface faces away from the viewer by at most one deviation.
pub fn wild_surfaces(n: usize, seed: u64) -> Vec<Surface> {
    let mut r = Random(seed);
    let mut out = Vec::with_capacity(n);
    while out.len() < n {
        let wo = spherical(r.range(0.0, 88f64.to_radians()), r.range(0.0, TAU));
        let (x, y, c) = (r.log(0.01, 2.5), r.log(0.01, 2.5), r.range(-0.95, 0.95));
        let m = DVec2::from_angle(r.range(0.0, TAU)) * r.range(0.0, 4.0);
        let s = DVec3::new(x * x, y * y, c * x * y);
        if meso_area(wo, m) > -slope_spread(wo, s) {
            out.push(Surface { wo, m, s });
        }
    }
    out
}
