//! Draws figures 6, 11 and 12: gloss and the length of the mean normal.

use super::rational;
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use glam::DVec3;
use leadr_maps::RgbImage;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::{
    CHAN_COMBINED_GLOSS, Shortening, chan_combine_gloss, combined_gloss_quotient,
};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Plot, Scale, Table, number};
use std::f64::consts::TAU;

/// GGX facets weighted by macrosurface area and by microsurface area.
const AREAS: [Shortening; 2] = [Shortening::ALL[0], Shortening::ALL[1]];
/// The coefficients of the paper's rational fits of the length (eq. 40 and 42).
const FITS: [(&str, [f64; 6]); 2] = [
    ("eq. 40", [0.66693, 0.0609009, 7.32398, 0.600464, -1.13467, 8.78264]),
    ("eq. 42", [0.66667, 0.0942205, 7.41935, 0.567111, -1.0881, 8.83582]),
];
/// The legible entries of Listing 8, a gloss and a length on each line.
const LISTING_8: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../leadr-reflectance/src/facets/chan_listing_8.txt"));

/// Returns the entries of Listing 8.
fn printed_lengths() -> Vec<(f64, f64)> {
    let entry = |line: &str| {
        let (gloss, length) = line.split_once(' ')?;
        // Printed glosses are 255ths rounded to six digits.
        Some(((255.0 * gloss.parse::<f64>().ok()?).round() / 255.0, length.parse().ok()?))
    };
    LISTING_8.lines().filter_map(entry).collect()
}

fn length(area: Shortening, gloss: f64) -> f64 {
    area.length(Gloss::Wwii.alpha(gloss))
}

/// Returns the numerator and the denominator of eq. 39.
fn cubic_over_quadratic(c: &[f64; 6], x: f64) -> [f64; 2] {
    [c[0] + x * (c[1] + x * (c[2] + x * c[3])), 1.0 + x * (c[4] + x * c[5])]
}

fn curve(c: &[f64; 6], x: f64) -> f64 {
    let [above, below] = cubic_over_quadratic(c, x);
    above / below
}

/// Fits eq. 39 to the length by gloss. With `fixed`, the curve passes through both ends of the length (eq. 41).
fn fitted(fixed: bool) -> [f64; 6] {
    let at = |i: u32| f64::from(i) / 255.0;
    let samples: Vec<(f64, f64)> = (0..256).map(at).map(|g| (g, length(AREAS[0], g))).collect();
    let [start, end] = [samples[0].1, samples[255].1];
    let coefficients = |p: &[f64]| match *p {
        [c1, c2, c4, c5] => [start, c1, c2, end * (1.0 + c4 + c5) - start - c1 - c2, c4, c5],
        [c0, c1, c2, c3, c4, c5] => [c0, c1, c2, c3, c4, c5],
        _ => unreachable!("a fit has four or six parameters"),
    };
    let count = if fixed { 4 } else { 6 };
    coefficients(&rational::fit(count, &samples, |gloss, p| cubic_over_quadratic(&coefficients(p), *gloss)))
}

/// Returns the length of the mean of `count` sampled normals (Listing 6). The samples are points of Halton's sequence.
fn sampled_length(alpha: f64, count: u32) -> f64 {
    let radical_inverse = |base: u32, mut i: u32| {
        let (mut sum, mut digit) = (0.0, 1.0);
        while i > 0 {
            digit /= f64::from(base);
            sum += f64::from(i % base) * digit;
            i /= base;
        }
        sum
    };
    let normal = |i: u32| {
        let (phi, u) = (TAU * radical_inverse(2, i), radical_inverse(3, i));
        let cos = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    (1..=count).map(normal).sum::<DVec3>().length() / f64::from(count)
}

fn over_gloss(value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    (0..=60).map(|i| f64::from(i) / 60.0).map(|g| (g, value(g))).collect()
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    lengths(page);
    combined(studio, page)
}

fn lengths(page: &mut Page) {
    let axes = (("gloss", Scale::Linear), ("length of the mean normal", Scale::Linear));
    page.begin(
        "Chan Figure 6",
        "The length of the mean normal by gloss, with texels weighted by micro- and by macrosurface area.",
    );
    let mut plot = Plot::new("Two areas", axes.0, axes.1);
    for (name, area) in ["macrosurface", "microsurface"].into_iter().zip(AREAS) {
        plot.line(name, over_gloss(|g| length(area, g)));
        page.check(format!("length at gloss 0, {name}"), length(area, 0.0));
    }
    page.html.plot(&plot);
    let apart =
        over_gloss(|g| length(AREAS[0], g) - length(AREAS[1], g)).into_iter().map(|(_, d)| d).fold(0.0, f64::max);
    page.find(&format!("the lengths differ by at most {}, at gloss 0.", number(apart)));
    page.check("largest difference", apart);

    page.begin(
        "Chan Figure 12",
        "The length by gloss, the 248 legible entries of Listing 8, and rational fits without and with fixed ends: the paper's, and fits of the \
        same form (eq. 39 and 41).",
    );
    let mut plot = Plot::new("Rational fits", axes.0, axes.1);
    plot.line("exact (eq. 26)", over_gloss(|g| length(AREAS[0], g)));
    let printed = printed_lengths();
    let errors: Vec<f64> = printed.iter().map(|&(gloss, printed)| printed - length(AREAS[0], gloss)).collect();
    plot.line("Listing 8", printed);
    let (least, worst) = errors.iter().fold((f64::MAX, f64::MIN), |(a, b), &e| (a.min(e), b.max(e)));
    page.check("Listing 8, entries", errors.len() as f64);
    page.check("Listing 8 less eq. 26, least", least);
    page.check("Listing 8 less eq. 26, mean", errors.iter().sum::<f64>() / errors.len() as f64);
    page.check("Listing 8 less eq. 26, largest", worst);
    page.find(&format!("the lengths of Listing 8 are {} to {} too long.", number(least), number(worst)));
    let mut table =
        Table::new("The fits against the paper's ends of the curve", ["", "gloss 0", "gloss 1", "largest error"]);
    table.row([Cell::from("Listing 8"), Cell::from("0.666670"), Cell::from("0.999958"), Cell::from(worst)]);
    let [start, end] = [0.0, 1.0].map(|g| length(AREAS[0], g));
    table.row([
        Cell::from("eq. 26"),
        Cell::from(format!("{start:.6}")),
        Cell::from(format!("{end:.6}")),
        Cell::from("0"),
    ]);
    let again = [("eq. 39, fitted", fitted(false)), ("eq. 41, fitted", fitted(true))];
    for (name, coefficients) in FITS.into_iter().chain(again) {
        plot.guide(name, over_gloss(|g| curve(&coefficients, g)));
        let error = over_gloss(|g| (curve(&coefficients, g) - length(AREAS[0], g)).abs());
        let worst = error.into_iter().map(|(_, e)| e).fold(0.0, f64::max);
        let [start, end] = [0.0, 1.0].map(|g| format!("{:.6}", curve(&coefficients, g)));
        table.row([Cell::from(name), Cell::from(start), Cell::from(end), Cell::from(worst)]);
        page.check(format!("{name}, largest error"), worst);
        page.find(&format!("{name} errs by at most {}.", number(worst)));
    }
    for count in [64, 1024, 16384] {
        let error = |g: f64| (sampled_length(Gloss::Wwii.alpha(g), count) - length(AREAS[0], g)).abs();
        let worst = over_gloss(error).into_iter().map(|(_, e)| e).fold(0.0, f64::max);
        let [start, end] = [0.0, 1.0].map(|g| format!("{:.6}", sampled_length(Gloss::Wwii.alpha(g), count)));
        let name = format!("Listing 6, {count} samples");
        page.check(format!("{name}, largest error"), worst);
        table.row([Cell::from(name), Cell::from(start), Cell::from(end), Cell::from(worst)]);
    }
    page.html.plot(&plot);
    page.html.table(&table);
}

/// Draws the gloss of a detail on a base: the product of the lengths, the paper's fit, and the difference.
fn combined(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    const SIDE: u32 = 32;
    page.begin(
        "Chan Figure 11",
        "The gloss of a detail on a base: from the product of the lengths, from the paper's rational fit (eq. 35 to 37), and ten times the \
        difference. The gloss of the base grows to the right, and that of the detail downwards.",
    );
    let at = |i: u32| [i % SIDE, i / SIDE].map(|k| f64::from(k) / f64::from(SIDE - 1));
    let exact = |[a, b]: [f64; 2]| AREAS[0].combine_gloss(a, b, Gloss::Wwii);
    let fit = |[a, b]: [f64; 2]| chan_combine_gloss(a, b);
    let by = |c: &[f64], [a, b]: [f64; 2]| {
        let [above, below] = combined_gloss_quotient(a, b, c);
        (above / below).clamp(0.0, 1.0)
    };
    let apart = |p: [f64; 2]| (exact(p) - fit(p)).abs();
    let mut figures = Vec::new();
    let values = |p: [f64; 2]| [exact(p), fit(p), 10.0 * apart(p)];
    for (k, (name, caption)) in
        [("exact", "product of the lengths"), ("fit", "eq. 35 to 37"), ("difference", "difference, times 10")]
            .into_iter()
            .enumerate()
    {
        let texels = (0..SIDE * SIDE).map(|i| [values(at(i))[k] as f32; 3]).collect();
        let image = RgbImage::new(SIDE, SIDE, texels).map_err(fault)?;
        let name = format!("chan-combined-{name}");
        figures.push(studio.picture(&name, &image, 1.0, caption, vec![caption.to_owned()])?.enlarged(6));
    }
    page.html.figures(&figures);
    let errors: Vec<f64> = (0..SIDE * SIDE).map(|i| apart(at(i))).collect();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    page.check("largest difference", worst);
    page.check("rms difference", rms);
    page.find(&format!("the fit is off by at most {} in gloss, {} rms.", number(worst), number(rms)));
    let samples: Vec<_> = (0..SIDE * SIDE).map(|i| (at(i), exact(at(i)))).collect();
    let again = rational::refit(CHAN_COMBINED_GLOSS.to_vec(), &samples, |p, c| by(c, *p));
    let errors = (0..SIDE * SIDE).map(|i| (exact(at(i)) - by(&again, at(i))).abs());
    let (squares, worst) = errors.fold((0.0, 0.0f64), |(sum, worst), e| (sum + e * e, worst.max(e)));
    page.check("fitted again, largest difference", worst);
    page.check("fitted again, rms difference", (squares / f64::from(SIDE * SIDE)).sqrt());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fits and samples find what the paper prints (docs/measurements/gloss.md).
    #[test]
    fn fits_and_samples_follow_the_length() {
        let worst = |value: &dyn Fn(f64) -> f64| {
            let errors = over_gloss(|g| (value(g) - length(AREAS[0], g)).abs());
            errors.into_iter().map(|(_, e)| e).fold(0.0, f64::max)
        };
        for ((name, printed), fixed) in FITS.iter().zip([false, true]) {
            let found = fitted(fixed);
            println!("{name}: {found:?}");
            let [ours, theirs] = [&found, printed].map(|fit| worst(&|g| curve(fit, g)));
            assert!(ours < 1.01 * theirs, "{name}: {ours} {theirs}");
            for (a, b) in found.iter().zip(printed) {
                assert!((a - b).abs() < 2e-3, "{name}: {found:?}");
            }
        }
        let sampled = [64, 1024, 16384].map(|count| worst(&|g| sampled_length(Gloss::Wwii.alpha(g), count)));
        println!("Listing 6: {sampled:?}");
        assert!(sampled[0] > 4.0 * sampled[1] && sampled[1] > 4.0 * sampled[2] && sampled[2] < 2e-4, "{sampled:?}");
    }
}
