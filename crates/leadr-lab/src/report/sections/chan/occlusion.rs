//! Draws figures 15 and 18: ambient occlusion by albedo, and a sun on bricks with occlusion cones.

use glam::{DVec3, Vec3};

use super::distance::Bumps;
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::masking::occlusion::{ConeEdge, Hidden, adjusted_visibility};
use leadr_render::settings::{ShadingOptions, Technique, Terms};
use leadr_tools::error::LabError;
use leadr_tools::html::{Plot, Scale, number};

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 15",
        "The adjusted ambient occlusion by the visibility, for albedos of 0 to 1: with all bounces (eq. 49), and of the albedo .8 with the \
        occlusion of the hidden directions (eq. 48, dashed).",
    );
    let visibilities = || (0..=40).map(|i| f64::from(i) / 40.0);
    let of = |hidden, rho: f64, a: f64| adjusted_visibility(hidden, a, DVec3::splat(rho)).x;
    let mut plot = Plot::new("A'", ("visibility A", Scale::Linear), ("A'", Scale::Linear));
    for rho in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        plot.line(&format!("ρ {rho}"), visibilities().map(|a| (a, of(Hidden::SameRadiance, rho, a))).collect());
    }
    plot.guide("eq. 48, ρ 0.8", visibilities().map(|a| (a, of(Hidden::SameOccluded, 0.8, a))).collect());
    page.html.plot(&plot);
    let apart = |rho: f64| {
        visibilities().map(|a| of(Hidden::SameRadiance, rho, a) - of(Hidden::SameOccluded, rho, a)).fold(0.0, f64::max)
    };
    page.check("eq. 49 less eq. 48, at most, at albedo .8", apart(0.8));
    page.find(&format!("at albedo .8, all bounces add up to {} to eq. 48.", number(apart(0.8))));

    page.begin(
        "Chan Figure 18",
        "A sun 25° above bumps of a normal map with occlusion cones: without shadows by cones, with a hard edge (eq. 57), with a linear edge, \
        and with its square (eq. 58).",
    );
    let size = studio.pick(64, 160);
    let mut bumps = Bumps::new(studio)?;
    let (mut figures, mut means) = (Vec::new(), Vec::new());
    let sun = Vec3::new(0.9, 0.2, 0.43).normalize();
    for cone_edge in [ConeEdge::Open, ConeEdge::Hard, ConeEdge::Linear, ConeEdge::Soft] {
        let options = ShadingOptions { terms: Terms::DIFFUSE_LIGHTS, cone_edge, ..Default::default() };
        let image = bumps.near(studio, size, Technique::Gloss.with(options), sun)?;
        means.push(Bumps::mean(&image));
        let (name, caption) = (format!("chan-edge-{}", cone_edge.name()), cone_edge.name().to_owned());
        figures.push(studio.picture(&name, &image, 1.0, &caption, vec![caption.clone()])?.enlarged(2));
    }
    page.html.figures(&figures);
    for (edge, mean) in ["hard", "linear", "soft"].into_iter().zip(&means[1..]) {
        page.check(format!("light left by the edge {edge}"), mean / means[0]);
    }
    let [hard, linear, soft] = [1, 2, 3].map(|k| number(means[k] / means[0]));
    page.find(&format!(
        "of the light without shadows, the edges leave {hard} (hard), {linear} (linear) and {soft} (soft)."
    ));
    Ok(())
}
