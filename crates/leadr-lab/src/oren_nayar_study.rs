//! Compares LEADR's diffuse term on a centred isotropic relief with the model of Oren and Nayar 1994, which LEADR §6 names as its
//! special case.

use crate::quadrature_study::surfaces::spherical;
use glam::{DVec2, DVec3};
use leadr_reflectance::integrals::reference::diffuse_directional;
use std::f64::consts::PI;

/// The slope deviations of the table.
pub const SIGMAS: [f64; 5] = [0.1, 0.2, 0.3, 0.5, 0.7];
/// The angles of the viewer and of the light, in degrees.
const ANGLES: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// The azimuths between viewer and light, in degrees.
const AZIMUTHS: [f64; 7] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
const PANELS: usize = 6;

/// Returns `π/ρ` times the BRDF of Oren and Nayar 1994, their functional approximation of both bounces. `wo` and `wi` are unit vectors
/// above the surface, `sigma` is the deviation of the facets' tilt in radians, and `albedo` is from 0 to 1. The second bounce is left out if
/// `interreflections` is false.
pub fn oren_nayar_1994(wo: DVec3, wi: DVec3, sigma: f64, albedo: f64, interreflections: bool) -> f64 {
    let (o, i) = (wo.z.clamp(0.0, 1.0).acos(), wi.z.clamp(0.0, 1.0).acos());
    let (alpha, beta) = (o.max(i), o.min(i));
    let across = DVec2::new(wo.x, wo.y).length() * DVec2::new(wi.x, wi.y).length();
    let cosine = if across > 1e-12 { (wo.x * wi.x + wo.y * wi.y) / across } else { 0.0 };
    let square = sigma * sigma;
    let c1 = 1.0 - 0.5 * square / (square + 0.33);
    let back = if cosine >= 0.0 { 0.0 } else { (2.0 * beta / PI).powi(3) };
    let c2 = 0.45 * square / (square + 0.09) * (alpha.sin() - back);
    let c3 = 0.125 * square / (square + 0.09) * (4.0 * alpha * beta / (PI * PI)).powi(2);
    let first = c1 + cosine * c2 * beta.tan() + (1.0 - cosine.abs()) * c3 * (0.5 * (alpha + beta)).tan();
    let second = 0.17 * albedo * square / (square + 0.13) * (1.0 - cosine * (2.0 * beta / PI).powi(2));
    if interreflections { first + second } else { first }
}

/// Returns `π` times the radiance of LEADR's white diffuse relief (LEADR eq. 20), with masking and shadowing, under a light of unit irradiance
/// on a plane that faces it.
pub fn leadr_diffuse(wo: DVec3, wi: DVec3, sigma: f64) -> f64 {
    PI * diffuse_directional(wo, wi, DVec2::ZERO, DVec3::new(sigma * sigma, sigma * sigma, 0.0), true, PANELS)
}

/// The differences for one roughness, in units of the radiance of a white Lambertian plane that faces the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayarRow {
    /// The slope deviation of LEADR's relief.
    pub sigma: f64,
    /// The RMS and largest difference from the model of one bounce, whose tilt has the deviation `arctan sigma`.
    pub first: [f64; 2],
    /// The same, for the model with interreflections of albedo 1.
    pub both: [f64; 2],
    /// The deviation of the tilt that has the least RMS difference with one bounce, and this RMS difference.
    pub best: [f64; 2],
    /// The RMS difference between LEADR and a Lambertian plane.
    pub lambert: f64,
    /// The BRDF times `π` at 60°, where viewer and light have the same direction: LEADR, Oren and Nayar with one bounce and with both.
    pub retro: [f64; 3],
}

/// Measures the differences over viewers and lights up to 75°.
pub fn oren_nayar_row(sigma: f64) -> OrenNayarRow {
    let direction = |theta: f64, phi: f64| spherical(theta.to_radians(), phi.to_radians());
    let pairs: Vec<(DVec3, DVec3, f64)> = ANGLES
        .iter()
        .flat_map(|&o| ANGLES.iter().flat_map(move |&i| AZIMUTHS.iter().map(move |&phi| (o, i, phi))))
        .map(|(o, i, phi)| (direction(o, 0.0), direction(i, phi)))
        .map(|(wo, wi)| (wo, wi, leadr_diffuse(wo, wi, sigma)))
        .collect();
    let difference = |of: &dyn Fn(DVec3, DVec3) -> f64| {
        let errors: Vec<f64> = pairs.iter().map(|(wo, wi, leadr)| of(*wo, *wi) * wi.z - leadr).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        [rms, errors.iter().map(|e| e.abs()).fold(0.0, f64::max)]
    };
    let tilt = sigma.atan();
    let best = (1..=300)
        .map(|k| f64::from(k) / 200.0 * tilt)
        .map(|t| [t, difference(&|wo, wi| oren_nayar_1994(wo, wi, t, 1.0, false))[0]])
        .min_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or_default();
    let at = direction(60.0, 0.0);
    OrenNayarRow {
        sigma,
        first: difference(&|wo, wi| oren_nayar_1994(wo, wi, tilt, 1.0, false)),
        both: difference(&|wo, wi| oren_nayar_1994(wo, wi, tilt, 1.0, true)),
        best,
        lambert: difference(&|_, _| 1.0)[0],
        retro: [
            leadr_diffuse(at, at, sigma) / at.z,
            oren_nayar_1994(at, at, tilt, 1.0, false),
            oren_nayar_1994(at, at, tilt, 1.0, true),
        ],
    }
}
