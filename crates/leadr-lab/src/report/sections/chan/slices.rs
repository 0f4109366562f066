//! Draws figure 30: slices of BRDFs by `θ_h` and `θ_d`.

use std::f64::consts::PI;

use glam::DVec3;

use super::laws::{AtGloss, F0, Law};
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::RgbImage;
use leadr_measured::slice::slice;
use leadr_reflectance::facets::fresnel::fresnel_schlick;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::microfacet::{half_vector, microfacet_eval};
use leadr_tools::error::LabError;
use leadr_tools::html::number;

/// The gloss of the moderately glossy material.
const MODERATE: f64 = 0.4;

/// The published fit with the specular term of GGX facets over it.
struct Full;

impl Brdf for Full {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let facets = Ggx::isotropic(glam::DVec2::ZERO, Gloss::Wwii.alpha(MODERATE));
        let fresnel = fresnel_schlick(DVec3::splat(F0), wi.dot(half_vector(wo, wi)));
        AtGloss(Law::Published, MODERATE).eval_cos(wo, wi)
            + fresnel * microfacet_eval(Masking::SmithCorrelated, &facets, wo, wi)
    }
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 30",
        "Slices at φ_d = 90°: θ_h grows to the right, and θ_d upwards, from 0° to 90°. The published fit at gloss 0, whose right edge is \
        retroreflection; the model of this project; the random walks; and the published fit with a GGX specular term at gloss .4, with the \
        specular peak at the left edge and the Fresnel peak at the top. Lambert's law is the grey of half the brightness.",
    );
    let side = studio.pick(30, 90);
    let walks = Law::Walks(studio.pick(200, 2000));
    let values = [Law::Published, Law::Ours, walks].map(|law| slice(&AtGloss(law, 0.0), side));
    // The walks are too noisy where one direction is at the horizon.
    let is_shown = |i: usize| {
        let angle = |k: usize| (k as f64 + 0.5) / side as f64 * 0.5 * PI;
        angle(i % side).cos() * angle(i / side).cos() > 0.05
    };
    let error = |a: &[DVec3], b: &[DVec3]| {
        let squares: Vec<f64> =
            (0..a.len()).filter(|i| is_shown(*i)).map(|i| (PI * (a[i].x - b[i].x)).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let [published, ours] = [0, 1].map(|k| error(&values[k], &values[2]));
    let [published_values, our_values, walked] = values;
    let mut figures = Vec::new();
    for (name, caption, values) in [
        ("published", "published fit, gloss 0", published_values),
        ("ours", "multiscattering_diffuse, gloss 0", our_values),
        ("walks", "random walks, gloss 0", walked),
        ("full", "with GGX specular, gloss .4", slice(&Full, side)),
    ] {
        // The picture begins with the top row.
        let texel = |i: usize| (0.5 * PI * values[(side - 1 - i / side) * side + i % side]).as_vec3().to_array();
        let image = RgbImage::new(side as u32, side as u32, (0..side * side).map(texel).collect()).map_err(fault)?;
        let scale = if studio.quick { 6 } else { 2 };
        let figure = studio.picture(&format!("chan-slice-{name}"), &image, 1.0, caption, vec![caption.to_owned()])?;
        figures.push(figure.enlarged(scale));
    }
    page.html.figures(&figures);
    page.check("published fit less the walks, rms of π f_r", published);
    page.check("multiscattering_diffuse less the walks, rms of π f_r", ours);
    page.find(&format!(
        "at gloss 0, the published fit differs from the walks by {} rms, and multiscattering_diffuse by {}.",
        number(published),
        number(ours)
    ));
    Ok(())
}
