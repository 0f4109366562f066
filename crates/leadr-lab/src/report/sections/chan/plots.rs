//! Draws figures 27 to 29, 31 and 32: plots of the diffuse laws.

use rayon::prelude::*;

use super::GLOSSES;
use super::laws::{Law, direction, slice_pair};
use super::rational;
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::materials::multiscattering::{CHAN_RATIONAL, slice_quotient};
use leadr_reflectance::quadrature::composite_gauss;
use leadr_tools::error::LabError;
use leadr_tools::html::{Plot, Scale, number};
use std::f64::consts::PI;

/// The largest angle of the plots in degrees. Walks are noisy at the horizon.
const MOST: f64 = 88.0;

type Points = Vec<(f64, f64)>;

fn points(xs: impl IntoParallelIterator<Item = f64>, value: impl Fn(f64) -> f64 + Sync + Send) -> Points {
    let mut points: Points = xs.into_par_iter().map(|x| (x, value(x))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

fn steps(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect()
}

/// Returns the root mean square difference of the values of two lines over the same positions.
fn apart(a: &Points, b: &Points) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a.1 - b.1).powi(2)).sum::<f64>() / a.len().max(1) as f64).sqrt()
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    let walks = Law::Walks(studio.pick(1000, 20_000));
    let count = studio.pick(22, 44);
    theta_v(page, walks, count);
    polar(page, walks, count);
    theta_h(page, walks, count);
    rational_fits(page, walks, count);
    Ok(())
}

/// Returns the pair of directions at these angles to the normal in degrees. A negative angle is on the other side.
fn in_plane(view: f64, light: f64) -> [glam::DVec3; 2] {
    [view, light].map(|angle| {
        let angle = angle.clamp(-MOST, MOST).to_radians();
        direction(angle.cos(), if angle < 0.0 { PI } else { 0.0 })
    })
}

fn theta_v(page: &mut Page, walks: Law, count: u32) {
    page.begin(
        "Chan Figure 27",
        "Rough surface (gloss 0): π f_r by the angle of the viewer, in the plane of a light 0°, 30°, 60° and 88° from the normal (the paper: \
        90°). Lambert's law, the full BRDF, the slice at φ_d = 90°, the published fit and the model of this project.",
    );
    for light in [0.0, 30.0, 60.0, MOST] {
        let title = format!("Light {light}° from the normal");
        let mut plot = Plot::new(&title, ("angle of the viewer, degrees", Scale::Linear), ("π f_r", Scale::Linear));
        let value = |law: Law, on_slice: bool| {
            points(steps(-MOST, MOST, 2 * count), |view| {
                let [wo, wi] = in_plane(view, light);
                let seed = view.to_bits() ^ light.to_bits();
                if on_slice { law.on_slice(wo, wi, 0.0, seed) } else { law.value(wo, wi, 0.0, seed) }
            })
        };
        let full = value(walks, false);
        let slice = value(walks, true);
        let (published, ours) = (value(Law::Published, false), value(Law::Ours, false));
        for (what, line) in
            [("the slice", &slice), ("the published fit", &published), ("multiscattering_diffuse", &ours)]
        {
            page.check(format!("light at {light}°: {what} less the full BRDF, rms"), apart(line, &full));
        }
        plot.guide("Lambert", vec![(-MOST, 1.0), (MOST, 1.0)]);
        plot.line("full BRDF", full);
        plot.line("slice", slice);
        plot.line("published fit", published);
        plot.line("multiscattering_diffuse", ours);
        page.html.plot(&plot);
    }
}

/// Returns a polar plot of `π f_r` by angles in degrees. The distance from the origin is `f_r`.
fn around(line: Points) -> Points {
    line.into_iter().map(|(view, r)| (r / PI * view.to_radians().sin(), r / PI * view.to_radians().cos())).collect()
}

fn polar(page: &mut Page, walks: Law, count: u32) {
    page.begin(
        "Chan Figure 28",
        "The same as polar plots: the distance from the origin is the radiance f_r, along the direction of the viewer, for a light 0°, 60°, \
        85° and 88° from the normal (the paper: 90°), on the right.",
    );
    for light in [0.0, 60.0, 85.0, MOST] {
        let title = format!("Light {light}° from the normal");
        let mut plot = Plot::new(&title, ("f_r sin θ", Scale::Linear), ("f_r cos θ", Scale::Linear));
        let curve = |law: Law, on_slice: bool| -> Points {
            let radius = points(steps(-MOST, MOST, 2 * count), |view| {
                let [wo, wi] = in_plane(view, light);
                let seed = view.to_bits() ^ light.to_bits();
                if on_slice { law.on_slice(wo, wi, 0.0, seed) } else { law.value(wo, wi, 0.0, seed) }
            });
            around(radius)
        };
        let (lambert, full) = (curve(Law::Lambert, false), curve(walks, false));
        let retro = full.last().map_or(0.0, |&(x, y)| PI * x.hypot(y));
        let forward = full.first().map_or(0.0, |&(x, y)| PI * x.hypot(y));
        page.check(format!("light at {light}°: π f_r at {MOST}° towards the light"), retro);
        page.check(format!("light at {light}°: π f_r at {MOST}° away from it"), forward);
        if light == MOST {
            page.find(&format!(
                "with the light at {MOST}°, π f_r of the full BRDF is {} towards the light and {} away from it.",
                number(retro),
                number(forward)
            ));
        }
        plot.guide("Lambert", lambert);
        plot.line("full BRDF", full);
        plot.line("slice", curve(walks, true));
        page.html.plot(&plot);
    }
}

fn theta_h(page: &mut Page, walks: Law, count: u32) {
    let mut lines = Vec::new();
    page.begin(
        "Chan Figure 29",
        "π f_r by θ_h with θ_d = 15°, for five glosses: the full BRDF in the plane of incidence (φ_d = 0), and the slice (φ_d = 90°). Lambert's \
        law is 1.",
    );
    let axes = || (("θ_h, degrees", Scale::Linear), ("π f_r", Scale::Linear));
    let mut plot = Plot::new("Full BRDF and slice", axes().0, axes().1);
    let difference = 15f64;
    let angles = steps(0.0, MOST - difference, count);
    for gloss in GLOSSES {
        let g = gloss / 255.0;
        let of = |law: Law, on_slice: bool| {
            points(angles.clone(), |h| {
                let [wo, wi] = if on_slice {
                    slice_pair(h.to_radians().cos(), difference.to_radians().cos())
                } else {
                    in_plane(h - difference, h + difference)
                };
                law.value(wo, wi, g, h.to_bits() ^ gloss.to_bits())
            })
        };
        let (full, slice) = (of(walks, false), of(walks, true));
        page.check(format!("gloss {gloss}: slice less full BRDF, rms"), apart(&slice, &full));
        plot.line(&format!("full BRDF, gloss {gloss}"), full);
        plot.guide(&format!("slice, gloss {gloss}"), slice.clone());
        lines.push((gloss, slice, of(Law::Published, true), of(Law::Ours, true)));
    }
    page.html.plot(&plot);
    page.begin("Chan Figure 32", "The slice of figure 29, the published fit, and the model of this project.");
    let (mut published, mut own) = (Vec::new(), Vec::new());
    for (gloss, slice, fit, ours) in lines {
        let mut plot = Plot::new(&format!("Gloss {gloss}/255"), axes().0, axes().1);
        published.push(apart(&fit, &slice));
        own.push(apart(&ours, &slice));
        page.check(format!("gloss {gloss}: published fit less slice, rms"), apart(&fit, &slice));
        page.check(format!("gloss {gloss}: multiscattering_diffuse less slice, rms"), apart(&ours, &slice));
        plot.line("slice", slice);
        plot.line("published fit", fit);
        plot.line("multiscattering_diffuse", ours);
        page.html.plot(&plot);
    }
    let list = |errors: &[f64]| errors.iter().map(|e| number(*e)).collect::<Vec<_>>().join(", ");
    page.find(&format!(
        "from the slice at gloss 0, 60, 120, 180 and 240, the published fit is {} off, and multiscattering_diffuse {}.",
        list(&published),
        list(&own)
    ));
}

/// Fits eq. 63 to the slice at gloss 0, beginning with the printed coefficients.
fn fitted(walks: Law, count: u32) -> Law {
    // Equal steps of the angles, as the paper's slices have them.
    let at = |i: u32| (MOST * (f64::from(i) + 0.5) / f64::from(count)).to_radians().cos();
    let pairs: Vec<[f64; 2]> = (0..count * count).map(|i| [at(i % count), at(i / count)]).collect();
    let sample = |(i, &[x, y]): (usize, &[f64; 2])| {
        let [wo, wi] = slice_pair(x, y);
        ([x, y], walks.value(wo, wi, 0.0, i as u64))
    };
    let samples: Vec<_> = pairs.par_iter().enumerate().map(sample).collect();
    let value = |&[x, y]: &[f64; 2], c: &[f64]| {
        let [above, below] = slice_quotient(x, y, c);
        PI * above / below
    };
    let coefficients = rational::refit(CHAN_RATIONAL.to_vec(), &samples, value);
    Law::RationalFit(coefficients.try_into().unwrap_or(CHAN_RATIONAL))
}

fn rational_fits(page: &mut Page, walks: Law, count: u32) {
    page.begin(
        "Chan Figure 31",
        "The paper's rational fit for gloss 0 (eq. 63), a fit of the same form, and the slice: albedo by the cosine of the viewer, π f_r by θ_h \
        at θ_d = 15°, by θ_d at θ_h = 15°, and by the viewer's angle for a light 60° from the normal, and f_r for the same light as a polar \
        plot.",
    );
    let again = fitted(walks, count / 2);
    let on = |law: Law, h: f64, d: f64, seed: u64| {
        let [wo, wi] = slice_pair(h.to_radians().cos(), d.to_radians().cos());
        law.value(wo, wi, 0.0, seed)
    };
    let azimuths = composite_gauss(0.0, PI, 1, 6);
    let cosines = composite_gauss(0.0, 1.0, 1, 8);
    let albedo = |law: Law, c: f64| {
        let ring = |u: f64| {
            azimuths
                .iter()
                .map(|(phi, w)| w * law.on_slice(direction(c, 0.0), direction(u, *phi), 0.0, (u * 1e6) as u64))
                .sum::<f64>()
        };
        cosines.iter().map(|(u, w)| w * 2.0 / PI * u * ring(*u)).sum::<f64>()
    };
    let line = |what: &str, law: Law| -> Points {
        match what {
            "albedo" => points(steps(0.05, 1.0, count / 2), |c| albedo(law, c)),
            "θ_h" => points(steps(0.0, 72.0, count), |h| on(law, h, 15.0, h.to_bits())),
            "θ_d" => points(steps(0.0, MOST, count), |d| on(law, 15.0, d, d.to_bits())),
            _ => points(steps(-MOST, MOST, 2 * count), |view| {
                let [wo, wi] = in_plane(view, 60.0);
                law.on_slice(wo, wi, 0.0, view.to_bits())
            }),
        }
    };
    for (what, x, y) in [
        ("albedo", "cosine of the viewer", "albedo"),
        ("θ_h", "θ_h, degrees", "π f_r"),
        ("θ_d", "θ_d, degrees", "π f_r"),
        ("θ_v", "angle of the viewer, degrees", "π f_r"),
    ] {
        let mut plot = Plot::new(what, (x, Scale::Linear), (y, Scale::Linear));
        let (slice, fit, again) = (line(what, walks), line(what, Law::Rational), line(what, again));
        page.check(format!("eq. 63 less the slice, by {what}, rms"), apart(&fit, &slice));
        page.check(format!("fit less the slice, by {what}, rms"), apart(&again, &slice));
        plot.line("slice", slice);
        plot.line("eq. 63", fit);
        plot.line("fitted again", again);
        page.html.plot(&plot);
    }
    let mut plot = Plot::new("polar", ("f_r sin θ", Scale::Linear), ("f_r cos θ", Scale::Linear));
    for (name, law) in [("slice", walks), ("eq. 63", Law::Rational), ("fitted again", again)] {
        plot.line(name, around(line("θ_v", law)));
    }
    page.html.plot(&plot);
}
