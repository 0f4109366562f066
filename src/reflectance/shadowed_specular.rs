//! Specular environments with the shadows that the surface throws on itself, for rules with few probes.
//!
//! A probe stands for all directions of its solid angle, not for one. What is lit of them
//! ([`lit_fraction`](super::correlated_masking::lit_fraction)) is governed by how far they rise above the mesosurface, and
//! falls to nothing below its horizon: a corner that few probes miss or hit by chance. So the projected area `a` of the
//! mesosurface is averaged over the probe, as a normal variable of the deviation that a disc of its solid angle has,
//! before it is cut at 0: the closed form is that of the visible area itself, and as smooth.

use super::correlated_masking::{DirectionArea, Visibility, direction_area, lit_fraction};
use super::fresnel::fresnel_schlick;
use super::projected_area::rough_area;
use super::visible_specular::{ProbeNode, VisibleProbe, visible_probe, visible_probes};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The areas that a light of this solid angle about `wi` sees, on average.
#[must_use]
pub fn wide_direction_area(wi: DVec3, solid_angle: f64, m: DVec2, cholesky: DVec3) -> DirectionArea {
    let i = direction_area(wi, m, cholesky);
    let deviation = (solid_angle * (1.0 + m.length_squared()) / (4.0 * PI)).min(1.0).sqrt();
    let wider = rough_area(i.meso, deviation);
    DirectionArea { meso: i.meso.max(0.0) + wider, visible: i.visible + wider, ..i }
}

/// Part of what the probe stands for that is lit, 0..1. `o`: the viewer's areas; `m`, `cholesky`: mean slope and Cholesky
/// factor that the probes were placed with.
#[must_use]
pub fn probe_lit(visibility: Visibility, o: &DirectionArea, probe: &VisibleProbe, m: DVec2, cholesky: DVec3) -> f64 {
    lit_fraction(visibility, o, &wide_direction_area(probe.wi, probe.solid_angle, m, cholesky))
}

/// Radiance towards `wo` under an environment, with shadows, and the mean Fresnel reflectance of the visible facets, by
/// the probes of `nodes`. `f0`: linear RGB reflectance at normal incidence. `radiance` is asked for each probe.
#[must_use]
pub fn shadowed_specular_environment(
    visibility: Visibility,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    nodes: &[ProbeNode],
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> (DVec3, DVec3) {
    let probes = visible_probes(wo, m, s);
    let o = direction_area(wo, probes.m, probes.cholesky);
    nodes.iter().fold((DVec3::ZERO, DVec3::ZERO), |(sum, fresnel), node| {
        let probe = visible_probe(&probes, wo, node);
        let f = probe.weight * fresnel_schlick(f0, probe.cosine);
        let lit = probe_lit(visibility, &o, &probe, probes.m, probes.cholesky);
        (sum + f * lit * radiance(&probe), fresnel + f)
    })
}
