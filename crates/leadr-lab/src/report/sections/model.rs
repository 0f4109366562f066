//! Measures errors of the model's masking and shadowing by comparison with ray-cast surfaces.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::ray_cast::{Patch, Spectrum, Tile};
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_reflectance::facets::projected_area::meso_area;
use leadr_reflectance::integrals::reference::{diffuse_directional, visible_mean};
use leadr_reflectance::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::quadrature::composite_gauss;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_cholesky};
use leadr_reflectance::visible::shadowed_environment::bent_normal;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, percent};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "Ray casts against random surfaces with Gaussian slopes, including shadows, compared with converged integrals of the \
    model with each shadowing model: none (masking alone, the supplement's simplified algorithms), Smith's height-correlated shadowing (LEADR eq. \
    13), and the direction-correlated one. The views are those of a sphere's pixels; each number is the RMS error over them, relative to \
    the RMS of the truth. Facets are white and diffuse, or perfect mirrors; light is reflected once. The truth comes from a few random \
    surfaces; the last column gives its noise.";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Light {
    Front,
    Side,
    Opposite,
    DiffuseEnvironment,
    SpecularEnvironment,
}

impl Light {
    const ALL: [Self; 5] =
        [Self::Front, Self::Side, Self::Opposite, Self::DiffuseEnvironment, Self::SpecularEnvironment];

    fn title(self) -> &'static str {
        match self {
            Self::Front => "diffuse, light from the viewer",
            Self::Side => "diffuse, light from the side",
            Self::Opposite => "diffuse, light from beyond",
            Self::DiffuseEnvironment => "diffuse, white environment",
            Self::SpecularEnvironment => "specular, white environment",
        }
    }

    /// Returns the direction of a directional light. The viewer is at polar angle `theta` and azimuth 0.
    fn direction(self, theta: f64) -> Option<DVec3> {
        match self {
            Self::Front => Some(polar(theta, 0.0)),
            Self::Side => Some(polar(FRAC_PI_4, 0.5 * PI)),
            Self::Opposite => Some(polar(PI / 3.0, PI)),
            Self::DiffuseEnvironment | Self::SpecularEnvironment => None,
        }
    }

    /// Returns the largest relative error at σ = 1 that the goals and the papers allow.
    fn goal(self) -> Option<f64> {
        match self {
            Self::Front => Some(0.02),
            Self::DiffuseEnvironment => Some(0.015),
            Self::SpecularEnvironment => Some(0.04),
            Self::Side | Self::Opposite => None,
        }
    }
}

fn polar(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

#[derive(Debug, Serialize)]
struct Measured {
    light: &'static str,
    sigma: f64,
    masking: f64,
    smith: f64,
    correlated: f64,
    /// The error if one irradiance lookup along a bent normal replaces the integral.
    bent_normal: Option<f64>,
    /// The relative noise of the truth.
    noise: f64,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let sigmas: &[f64] = if studio.quick { &[0.25, 0.5, 1.0, 2.0] } else { &[0.05, 0.25, 0.5, 1.0, 1.5, 2.0] };
    let (views, rays, seeds, side) = studio.pick((8, 128, 3, 256), (24, 384, 6, 512));
    let tiles: Vec<Tile> = (0..seeds).map(|seed| Tile::new(Spectrum::Gaussian, side, 8.0, seed)).collect();
    studio.steps(sigmas.len() * Light::ALL.len());
    let mut measured = Vec::new();
    for &sigma in sigmas {
        for light in Light::ALL {
            measured.push(measure(light, sigma, views, rays, &tiles));
            studio.step();
        }
    }
    let mut html = Html::new();
    for light in Light::ALL {
        html.plot(&plot(light, &measured));
    }
    html.table(&table(&measured));
    let (areas, apart) = projected_areas(&tiles[0], rays);
    html.table(&areas);
    let mut findings: Vec<String> = Light::ALL.iter().filter_map(|&light| finding(light, &measured)).collect();
    findings.push(format!(
        "the projected area of a random surface, as the mesonormal's, as the sum over all facets and as the sum over visible facets: the three \
         differ by at most {} (LEADR supplement, Table 1).",
        percent(apart, false)
    ));
    Section::new(INTRO, findings, &html, &measured)
}

/// Computes the projected area of a random surface by the ways of the supplement's Table 1: as the mesonormal's (b), as the sum over all facets
/// without clamping (c), and as the sum over the visible facets (d). Also returns the largest relative difference.
fn projected_areas(tile: &Tile, rays: u32) -> (Table, f64) {
    const SIGMA: f64 = 0.5;
    let mean = DVec2::new(0.2, -0.1);
    let patch = Patch::new(tile, mean, DVec3::new(SIGMA * SIGMA, SIGMA * SIGMA, 0.0));
    let mut table = Table::new(
        "LEADR supplement, Table 1: the projected area of a surface of σ = .5 and mean slope (.2, −.1)",
        ["viewer", "(b) mesonormal", "(c) all facets", "(d) visible facets", "all facets that face the viewer"],
    );
    let mut apart = 0.0f64;
    for degrees in [0.0f64, 30.0, 60.0, 75.0] {
        let wo = polar(degrees.to_radians(), 2.0);
        let facing = patch.facing_area(wo);
        let areas = [meso_area(wo, mean), patch.signed_area(wo), facing * (1.0 - patch.masked_fraction(wo, rays, 1))];
        apart = areas.iter().map(|area| (area / areas[0] - 1.0).abs()).fold(apart, f64::max);
        let cell = |area: f64| Cell::from(format!("{area:.4}"));
        table.row([Cell::from(format!("{degrees}°")), cell(areas[0]), cell(areas[1]), cell(areas[2]), cell(facing)]);
    }
    (table, apart)
}

/// Computes the model's radiance for one view with each shadowing model, and with the bent normal if applicable.
fn model(light: Light, theta: f64, s: DVec3) -> ([f64; 3], Option<f64>) {
    let (wo, m) = (polar(theta, 0.0), DVec2::ZERO);
    let cholesky = slope_cholesky(s);
    let o = direction_area(wo, m, cholesky);
    let forms = [Shadowing::None, Shadowing::Smith, Shadowing::Correlated];
    let lit = |wi: DVec3| forms.map(|form| lit(form, &o, wi, m, cholesky));
    match light {
        Light::Front | Light::Side | Light::Opposite => {
            let wi = light.direction(theta).unwrap_or(DVec3::Z);
            let unshadowed = diffuse_directional(wo, wi, m, s, false, 3);
            (lit(wi).map(|share| unshadowed * share), None)
        }
        Light::DiffuseEnvironment => {
            // A directional light may come from any direction. Light from below the mesosurface passes only with masking
            // alone.
            let mut sums = [0.0; 3];
            for (z, weight) in composite_gauss(0.0, 1.0, 1, 16) {
                const AROUND: u32 = 32;
                for k in 0..AROUND {
                    let wi = polar(z.acos(), TAU * (f64::from(k) + 0.5) / f64::from(AROUND));
                    let solid_angle = weight * TAU / f64::from(AROUND);
                    let radiance = diffuse_directional(wo, wi, m, s, false, 1) * solid_angle;
                    for (sum, share) in sums.iter_mut().zip(lit(wi)) {
                        *sum += radiance * share;
                    }
                }
            }
            // Without shadows, white facets in a white environment have the radiance of the environment.
            sums[0] = 1.0;
            (sums, Some(bent_normal(&o, m, cholesky).open))
        }
        Light::SpecularEnvironment => {
            let mean = visible_mean(wo, m, s, 6, |slope| {
                let wn = normal_of_slope(slope);
                DVec3::from_array(lit(2.0 * wn.dot(wo) * wn - wo))
            });
            (mean.to_array(), None)
        }
    }
}

fn lit(form: Shadowing, o: &DirectionArea, wi: DVec3, m: DVec2, cholesky: DVec3) -> f64 {
    lit_fraction(form, o, &direction_area(wi, m, cholesky))
}

fn measure(light: Light, sigma: f64, views: u32, rays: u32, tiles: &[Tile]) -> Measured {
    let s = DVec3::new(sigma * sigma, sigma * sigma, 0.0);
    let (mut squares, mut bent, mut truth_squares, mut noise_squares) = ([0.0f64; 3], 0.0, 0.0f64, 0.0f64);
    let mut has_bent = false;
    for view in 0..views {
        // Each view covers an equal area in the picture of a sphere.
        let theta = ((f64::from(view) + 0.5) / f64::from(views)).sqrt().asin();
        let casts: Vec<f64> = tiles
            .iter()
            .enumerate()
            .filter_map(|(seed, tile)| cast(light, theta, &Patch::new(tile, DVec2::ZERO, s), rays, seed as u64))
            .collect();
        let truth = casts.iter().sum::<f64>() / casts.len().max(1) as f64;
        let spread = casts.iter().map(|c| (c - truth).powi(2)).sum::<f64>();
        noise_squares += spread / (casts.len().max(2) * (casts.len().max(2) - 1)) as f64;
        truth_squares += truth * truth;
        let (answers, by_bent_normal) = model(light, theta, s);
        for (square, answer) in squares.iter_mut().zip(answers) {
            *square += (answer - truth).powi(2);
        }
        if let Some(answer) = by_bent_normal {
            has_bent = true;
            bent += (answer - truth).powi(2);
        }
    }
    let share = |square: f64| (square / truth_squares.max(1e-30)).sqrt();
    Measured {
        light: light.title(),
        sigma,
        masking: share(squares[0]),
        smith: share(squares[1]),
        correlated: share(squares[2]),
        bent_normal: has_bent.then(|| share(bent)),
        noise: share(noise_squares),
    }
}

/// Casts rays at one random surface, and returns its radiance with shadows.
fn cast(light: Light, theta: f64, patch: &Patch<'_>, rays: u32, seed: u64) -> Option<f64> {
    let wo = polar(theta, 0.0);
    let estimate = match light {
        Light::Front | Light::Side | Light::Opposite => patch.diffuse_light(wo, light.direction(theta)?, rays, seed)?,
        Light::DiffuseEnvironment => patch.diffuse_environment(wo, rays, 4, seed, |_| 1.0)?,
        Light::SpecularEnvironment => patch.specular_environment(wo, rays, seed, |_| 1.0)?,
    };
    Some(estimate.mean[1])
}

fn plot(light: Light, measured: &[Measured]) -> Plot {
    let mut plot = Plot::new(light.title(), ("σ", Scale::Log), ("relative RMSE", Scale::Log));
    let mut line = |name: &str, pick: fn(&Measured) -> f64| {
        let of = measured.iter().filter(|m| m.light == light.title());
        plot.line(name, of.map(|m| (m.sigma, pick(m))).collect());
    };
    line("masking alone", |m| m.masking);
    line("Smith", |m| m.smith);
    line("direction-correlated", |m| m.correlated);
    if light == Light::DiffuseEnvironment {
        line("bent normal, one lookup", |m| m.bent_normal.unwrap_or(f64::NAN));
    }
    let noise = measured.iter().filter(|m| m.light == light.title()).map(|m| (m.sigma, m.noise)).collect();
    plot.guide("noise of the truth", noise);
    plot
}

fn table(measured: &[Measured]) -> Table {
    let mut table = Table::new(
        "Relative RMSE against ray-cast surfaces",
        ["light", "σ", "masking alone", "Smith", "direction-correlated", "bent normal", "noise of the truth"],
    );
    for m in measured {
        let text = |share: f64| Cell::from(percent(share, false));
        table.row([
            m.light.into(),
            Cell::Number(m.sigma),
            text(m.masking),
            text(m.smith),
            text(m.correlated),
            m.bent_normal.map_or(Cell::from(""), text),
            text(m.noise),
        ]);
    }
    table
}

fn finding(light: Light, measured: &[Measured]) -> Option<String> {
    let m = measured.iter().find(|m| m.light == light.title() && m.sigma == 1.0)?;
    let best = m.correlated.min(m.bent_normal.unwrap_or(f64::INFINITY));
    let goal = light.goal().map_or(String::new(), |goal| {
        let verdict = match () {
            () if best <= goal => "met",
            () if best <= goal + m.noise => "met within the noise",
            () => "missed",
        };
        format!("; the goal of {} is {verdict}", percent(goal, false))
    });
    let bent =
        m.bent_normal.map_or(String::new(), |b| format!(", {} with one lookup along a bent normal", percent(b, false)));
    Some(format!(
        "{} at σ = 1: the error is {} with masking alone, {} with Smith, {} direction-correlated{bent}{goal} (noise of the truth {}).",
        light.title(),
        percent(m.masking, false),
        percent(m.smith, false),
        percent(m.correlated, false),
        percent(m.noise, false),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projected_areas_agree() {
        let (_, apart) = projected_areas(&Tile::new(Spectrum::Gaussian, 128, 8.0, 0), 256);
        assert!(apart < 0.01, "{apart}");
    }
}
