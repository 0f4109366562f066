//! Samples a material at pairs of directions, to compare it with its fit.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use crate::facets::radial_table::angle_at;
use crate::materials::brdf::Brdf;
use crate::materials::half_difference::{HalfDifference, half_difference_to_directions};

/// The numbers of steps over `θ_h`, `θ_d` and `φ_d`. The steps over `θ_h` are denser at the highlight. Anisotropic materials also have
/// `AZIMUTHS` steps over `φ_h`.
const STEPS: [usize; 3] = [72, 24, 8];
const AZIMUTHS: usize = 24;

/// Returns the direction at the angle `theta` to z and the azimuth `phi`.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Returns the direction to the viewer, the direction to the light, and the half vector, for these half and difference angles.
pub fn pair(theta_h: f64, phi_h: f64, theta_d: f64, phi_d: f64) -> (DVec3, DVec3, DVec3) {
    let wh = direction(theta_h, phi_h);
    let (wo, wi) = half_difference_to_directions(&HalfDifference { wh, wd: direction(theta_d, phi_d) });
    (wo, wi, wh)
}

/// A direction pair and its reflectance.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The direction towards the viewer.
    pub wo: DVec3,
    /// The direction towards the light.
    pub wi: DVec3,
    /// The half vector.
    pub wh: DVec3,
    /// The reflectance `f_r` of the material.
    pub value: DVec3,
    /// The weight of the pair, which is proportional to the solid angles and the cosines of the two directions. The weights sum to one.
    pub weight: f64,
}

/// Samples a material at pairs of directions over both hemispheres.
pub fn samples(brdf: &dyn Brdf, isotropic: bool) -> Vec<Sample> {
    let azimuths = if isotropic { 1 } else { AZIMUTHS };
    let mut all = Vec::new();
    for h in 0..STEPS[0] {
        let u = (h as f64 + 0.5) / STEPS[0] as f64;
        let theta_h = angle_at(u);
        for d in 0..STEPS[1] {
            let theta_d = (d as f64 + 0.5) / STEPS[1] as f64 * FRAC_PI_2;
            for p in 0..STEPS[2] {
                let phi_d = (p as f64 + 0.5) / STEPS[2] as f64 * PI;
                for k in 0..azimuths {
                    let (wo, wi, wh) = pair(theta_h, TAU * k as f64 / azimuths as f64, theta_d, phi_d);
                    if wo.z <= 0.01 || wi.z <= 0.01 {
                        continue;
                    }
                    // The solid angles are related by dω_i dω_o = 4 cos θ_d dω_h dω_d.
                    let weight = u * theta_h.sin() * theta_d.sin() * theta_d.cos() * wo.z * wi.z;
                    all.push(Sample { wo, wi, wh, value: brdf.eval(wo, wi), weight });
                }
            }
        }
    }
    let sum: f64 = all.iter().map(|sample| sample.weight).sum();
    all.iter_mut().for_each(|sample| sample.weight /= sum);
    all
}

/// The distance of a fit from the samples of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// The rms difference of `f_r`, relative to the rms value of `f_r`.
    pub rrmse: f64,
    /// The relative rms difference of the cube root of `f_r cos θ_i`, which is perceptually more uniform.
    pub perceptual: f64,
    /// The generalised Kullback–Leibler divergence, divided by the mean `f_r`.
    pub divergence: f64,
}

/// Returns the misfit of `fit` over all samples.
pub fn misfit(samples: &[Sample], fit: &dyn Brdf) -> Misfit {
    let (mut square, mut all, mut roots, mut all_roots, mut divergence, mut sum) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for s in samples {
        let model = fit.eval(s.wo, s.wi);
        square += s.weight * (model - s.value).length_squared();
        all += s.weight * s.value.length_squared();
        let root = |f: f64| (f * s.wi.z).cbrt();
        for (m, f) in model.to_array().into_iter().zip(s.value.to_array()) {
            roots += s.weight * (root(m) - root(f)).powi(2);
            all_roots += s.weight * root(f).powi(2);
            divergence += s.weight * (if f > 0.0 { f * (f / m.max(1e-12)).ln() } else { 0.0 } - f + m);
            sum += s.weight * f;
        }
    }
    Misfit { rrmse: (square / all).sqrt(), perceptual: (roots / all_roots).sqrt(), divergence: divergence / sum }
}
