//! Plots of cuts through the lobes of a measured material and its fits, in the plane of incidence.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::html::{Plot, Scale};
use leadr_reflectance::color::luminance;
use leadr_reflectance::materials::brdf::Brdf;

/// The number of segments of a curve over 90 degrees.
const POINTS: i32 = 180;
/// The smallest plotted value, relative to the largest.
const LEAST: f64 = 1e-5;

/// Plots `f_r cos θ_i` over the viewing angle. The light is at `degrees` from the normal, or at the viewer if `degrees` is
/// `None`.
pub fn lobe_plot(materials: &[(&str, &dyn Brdf)], degrees: Option<f64>) -> Plot {
    let title = match degrees {
        Some(degrees) => format!("Light at {degrees}°, in the plane of incidence"),
        None => "Backscattering".to_owned(),
    };
    let mut plot =
        Plot::new(&title, ("viewing angle, degrees", Scale::Linear), ("luminance of f_r cos θ_i", Scale::Log));
    let direction = |theta: f64| DVec3::new(theta.sin(), 0.0, theta.cos());
    for &(name, material) in materials {
        let at = |i: i32| {
            let theta = f64::from(i) / f64::from(POINTS) * FRAC_PI_2;
            let wo = direction(theta);
            // The light is on the left, so the specular peak is on the right.
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
