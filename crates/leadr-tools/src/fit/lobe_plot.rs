//! Cuts through lobes: a measured material and its fits in the plane of the light.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::html::{Plot, Scale};
use leadr_reflectance::color::luminance;
use leadr_reflectance::materials::brdf::Brdf;

/// Points of a line.
const POINTS: i32 = 180;
/// Least value shown, as a part of the largest.
const LEAST: f64 = 1e-5;

/// `f_r cos θ_i` over the viewer's angle for a light at `degrees` from the normal, or in backscattering without one.
pub fn lobe_plot(materials: &[(&str, &dyn Brdf)], degrees: Option<f64>) -> Plot {
    let title = match degrees {
        Some(degrees) => format!("Lit from {degrees}°, seen in the plane of the light"),
        None => "Seen from where it is lit".to_owned(),
    };
    let mut plot =
        Plot::new(&title, ("angle of the viewer, degrees", Scale::Linear), ("luminance of f_r cos θ_i", Scale::Log));
    let direction = |theta: f64| DVec3::new(theta.sin(), 0.0, theta.cos());
    for &(name, material) in materials {
        let at = |i: i32| {
            let theta = f64::from(i) / f64::from(POINTS) * FRAC_PI_2;
            let wo = direction(theta);
            // The light on the left, so that mirrors are on the right.
            let wi = degrees.map_or(wo, |degrees| direction(-degrees.to_radians()));
            (theta.to_degrees(), luminance(material.eval(wo, wi)) * wi.z)
        };
        let from = if degrees.is_some() { 1 - POINTS } else { 0 };
        let points: Vec<(f64, f64)> = (from..POINTS).map(at).collect();
        let least = LEAST * points.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        plot.line(name, points.into_iter().filter(|(_, value)| *value > least).collect());
    }
    plot
}
