//! Measures the rules for the clamped cosine of diffuse facets under one light.

use super::Row;
use super::surfaces::{Surface, spherical, surfaces};
use glam::DVec3;
use leadr_reflectance::facets::projected_area::face_viewer;
use leadr_reflectance::integrals::diffuse::{leadr_diffuse_light, leadr_diffuse_light_sh};
use leadr_reflectance::integrals::reference::diffuse_directional;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::grid_lambda;
use leadr_reflectance::visible::diffuse::{leadr_diffuse_light_visible, visible_diffuse_moments};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The number of panels of the converged integrals between two kinks.
const PANELS: usize = 6;

/// Random surfaces, each with one light and the converged cosine.
pub struct LightSet {
    surfaces: Vec<Surface>,
    lights: Vec<DVec3>,
    truth: Vec<f64>,
}

/// Returns lights up to 88° from the displacement direction. An eighth of the lights reach 120°, below the horizon.
pub fn random_lights(n: usize, seed: u64) -> Vec<DVec3> {
    let mut r = Random(seed);
    (0..n)
        .map(|_| {
            let top = if r.unit() < 0.125 { 120f64 } else { 88.0 };
            spherical(r.range(0.0, top.to_radians()), r.range(0.0, TAU))
        })
        .collect()
}

impl LightSet {
    /// Returns `n` surfaces with [`random_lights`].
    pub fn new(n: usize, seed: u64) -> Self {
        Self::of(surfaces(n, seed), random_lights(n, seed + 2))
    }

    /// Returns these surfaces, each under one light.
    pub fn of(surfaces: Vec<Surface>, lights: Vec<DVec3>) -> Self {
        let truth = surfaces
            .par_iter()
            .zip(&lights)
            .map(|(s, &wi)| PI * diffuse_directional(s.wo, wi, s.m, s.s, false, PANELS))
            .collect();
        Self { surfaces, lights, truth }
    }

    /// Returns the surfaces, each with its light and the converged cosine.
    pub fn samples(&self) -> impl Iterator<Item = (&Surface, DVec3, f64)> {
        self.surfaces.iter().zip(&self.lights).zip(&self.truth).map(|((s, &wi), &truth)| (s, wi, truth))
    }

    /// Measures the absolute errors of a rule for the mean cosine, which is 1 for a facet that faces the light.
    pub fn row(&self, name: &str, evaluations: u32, rule: impl Fn(&Surface, DVec3) -> f64 + Sync) -> Row {
        let errors: Vec<Vec<f64>> = self
            .surfaces
            .par_iter()
            .zip(&self.lights)
            .zip(&self.truth)
            .map(|((s, &wi), truth)| vec![rule(s, wi) - truth])
            .collect();
        Row::new(name, evaluations, &self.surfaces, &errors)
    }

    /// Measures harmonics with converged moments, the paper's grids, and the rules with two clamps.
    pub fn rows(&self) -> Vec<Row> {
        let grid = |n: u32| self.row(&format!("paper {n}x{n}"), n * n, |s, wi| grid_cosine(s, wi, n));
        let terms = |n: u32| {
            self.row(&format!("visible {n} terms"), n, |s, wi| {
                PI * leadr_diffuse_light_visible(s.wo, wi, s.m, s.s, false, n)
            })
        };
        let harmonics = self.row("harmonics, 3 terms", 3, |s, wi| {
            let v = visible_diffuse_moments(s.wo, s.m, s.s, 3);
            PI * leadr_diffuse_light_sh(&v, s.wo, wi, s.m, s.s, false)
        });
        vec![
            grid(1),
            grid(3),
            grid(5),
            grid(7),
            grid(9),
            grid(16),
            grid(32),
            grid(64),
            grid(128),
            harmonics,
            terms(2),
            terms(3),
        ]
    }
}

/// Computes the cosine by the paper's grid, as the renderer implements it.
pub fn grid_cosine(surface: &Surface, wi: DVec3, n: u32) -> f64 {
    let lambda = grid_lambda(n);
    let m = face_viewer(surface.wo, surface.m, surface.s, lambda);
    PI * leadr_diffuse_light(surface.wo, wi, m, surface.s, false, n, lambda)
}
