//! Draws figures 6, 11 and 12: gloss and the length of the mean normal.

use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::RgbImage;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::Shortening;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Plot, Scale, Table, number};

/// GGX facets weighted by macrosurface area and by microsurface area.
const AREAS: [Shortening; 2] = [Shortening::ALL[0], Shortening::ALL[1]];
/// The coefficients of the paper's rational fits of the length (eq. 40 and 42).
const FITS: [(&str, [f64; 6]); 2] = [
    ("eq. 40", [0.66693, 0.0609009, 7.32398, 0.600464, -1.13467, 8.78264]),
    ("eq. 42", [0.66667, 0.0942205, 7.41935, 0.567111, -1.0881, 8.83582]),
];

fn length(area: Shortening, gloss: f64) -> f64 {
    area.length(Gloss::Wwii.alpha(gloss))
}

fn rational(c: &[f64; 6], x: f64) -> f64 {
    (c[0] + x * (c[1] + x * (c[2] + x * c[3]))) / (1.0 + x * (c[4] + x * c[5]))
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

    page.begin("Chan Figure 12", "The length by gloss and the paper's rational fits, without and with fixed ends.");
    let mut plot = Plot::new("Rational fits", axes.0, axes.1);
    plot.line("exact (eq. 26)", over_gloss(|g| length(AREAS[0], g)));
    let mut table =
        Table::new("The fits against the paper's ends of the curve", ["", "gloss 0", "gloss 1", "largest error"]);
    table.row([Cell::from("paper's table"), Cell::from(0.66667), Cell::from(0.999958), Cell::from("")]);
    let [start, end] = [0.0, 1.0].map(|g| length(AREAS[0], g));
    table.row([
        Cell::from("eq. 26"),
        Cell::from(format!("{start:.6}")),
        Cell::from(format!("{end:.6}")),
        Cell::from("0"),
    ]);
    for (name, coefficients) in FITS {
        plot.guide(name, over_gloss(|g| rational(&coefficients, g)));
        let error = over_gloss(|g| (rational(&coefficients, g) - length(AREAS[0], g)).abs());
        let worst = error.into_iter().map(|(_, e)| e).fold(0.0, f64::max);
        let [start, end] = [0.0, 1.0].map(|g| format!("{:.6}", rational(&coefficients, g)));
        table.row([Cell::from(name), Cell::from(start), Cell::from(end), Cell::from(worst)]);
        page.check(format!("{name}, largest error"), worst);
        page.find(&format!("{name} errs by at most {}.", number(worst)));
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
    let exact =
        |[a, b]: [f64; 2]| Gloss::Wwii.gloss(AREAS[0].alpha_of_length(length(AREAS[0], a) * length(AREAS[0], b)));
    let fit = |[a, b]: [f64; 2]| {
        let (sum, squares, product) = (a + b, a * a + b * b, a * b);
        let above = -0.53558 + 1.002204 * sum - 0.22391 * squares + 13.32315 * product;
        (above / (1.0 + 8.259559 * sum + 9.896132 * squares - 22.015902 * product)).clamp(0.0, 1.0)
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
    Ok(())
}
