//! Draws thesis Figure 3.6, which compares slopes from several difference schemes.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::derive::{Difference, slopes_of_heights};
use leadr_maps::{HeightMap, LeadrMap, RgbImage, Wrap};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::normal_of_slope;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use leadr_tools::metrics::compare::rrmse;

/// The number of texels along a side of the map.
const SIDE: u32 = 96;
/// The largest number of wave periods along a side. The shortest wave has 8 texels.
const PERIODS: i32 = 12;
const WAVES: u32 = 40;
const SLOPE: f64 = 0.3;
/// The number of pixels per texel on the page.
const SCALE: u32 = 3;

struct Wave {
    turns: DVec2,
    phase: f64,
}

/// A smooth map whose slopes have a closed form.
struct Smooth {
    waves: Vec<Wave>,
    amplitude: f64,
}

impl Smooth {
    fn new() -> Self {
        let mut random = Random::stream(11, 0);
        let mut wave = || loop {
            let mut whole = || random.range(-f64::from(PERIODS), f64::from(PERIODS)).round();
            let turns = DVec2::new(whole(), whole());
            if (2.0..=f64::from(PERIODS)).contains(&turns.length()) {
                return Wave { turns, phase: random.unit() };
            }
        };
        let waves: Vec<Wave> = (0..WAVES).map(|_| wave()).collect();
        // Every wave has the same slope amplitude.
        let amplitude = SLOPE * 2.0 / (TAU * f64::from(WAVES).sqrt());
        Self { waves, amplitude }
    }

    /// Returns the height and slope at a point in the unit square.
    fn at(&self, position: DVec2) -> (f64, DVec2) {
        let mut sums = (0.0, DVec2::ZERO);
        for wave in &self.waves {
            let amplitude = self.amplitude / wave.turns.length();
            let (sin, cos) = (TAU * (wave.turns.dot(position) + wave.phase)).sin_cos();
            sums.0 += amplitude * sin;
            sums.1 += amplitude * TAU * cos * wave.turns;
        }
        sums
    }

    fn texels<T>(&self, of: impl Fn(f64, DVec2) -> T) -> Vec<T> {
        let position = |i: u32| (DVec2::new(f64::from(i % SIDE), f64::from(i / SIDE)) + 0.5) / f64::from(SIDE);
        (0..SIDE * SIDE).map(|i| self.at(position(i))).map(|(height, slope)| of(height, slope)).collect()
    }
}

/// Computes forward differences at even texels and backward differences at odd texels, like screen-space derivatives.
fn pairs(map: &HeightMap) -> Vec<DVec2> {
    let at = |x: u32, y: u32| f64::from(map.at(x % SIDE, y % SIDE));
    let texel = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        let (even_x, even_y) = (x & !1, y & !1);
        DVec2::new(at(even_x + 1, y) - at(even_x, y), at(x, even_y + 1) - at(x, even_y)) * f64::from(SIDE)
    };
    (0..SIDE * SIDE).map(texel).collect()
}

/// Shades the slopes as a material that is lit from the side.
fn shaded(slopes: &[DVec2]) -> RgbImage {
    let light = DVec3::new(-0.5, 0.4, 0.7).normalize();
    let facets = Microfacet {
        distribution: Beckmann::isotropic(DVec2::ZERO, 0.25),
        masking: Masking::default(),
        fresnel: Fresnel::Schlick(DVec3::splat(0.3)),
    };
    let texel = |slope: &DVec2| {
        let n = normal_of_slope(*slope);
        let x = DVec3::Y.cross(n).normalize();
        let local = |w: DVec3| DVec3::new(w.dot(x), w.dot(n.cross(x)), w.dot(n));
        let wi = local(light);
        let diffuse = DVec3::new(0.30, 0.27, 0.24) * wi.z.max(0.0);
        (diffuse + facets.eval_cos(local(DVec3::Z), wi)).as_vec3().to_array()
    };
    RgbImage { width: SIDE, height: SIDE, texels: slopes.iter().map(texel).collect() }
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Thesis Figure 3.6",
        "A smooth map of waves of 8 texels and more, shaded by its own slopes and by finite differences of its heights. LEADR maps use \
        the first scheme: central differences of the triangles between texels, with weight 3/4 for the texel's own row and 1/8 for each \
        neighbouring row; the second moments hold what the mean slope loses.",
    );
    let smooth = Smooth::new();
    let map = HeightMap::new(SIDE, SIDE, smooth.texels(|height, _| height as f32)).map_err(fault)?;
    let truth = smooth.texels(|_, slope| slope);
    let shown = shaded(&truth);
    let of = |difference: Difference| -> Vec<DVec2> {
        let slopes = slopes_of_heights(&map, 1.0, Wrap::Repeat, difference);
        slopes.texels().iter().map(|s| DVec2::new(s[0].into(), s[1].into())).collect()
    };
    let schemes = [
        ("LEADR map", of(Difference::Triangles)),
        ("central", of(Difference::Central)),
        ("forward", of(Difference::Forward)),
        ("forward or backward, by parity", pairs(&map)),
    ];
    let leadr = LeadrMap::new(&map, Wrap::Repeat);
    let mean = |of: &dyn Fn(usize) -> f64| (0..truth.len()).map(of).sum::<f64>() / truth.len() as f64;
    let power = mean(&|i| truth[i].length_squared());
    let kept = mean(&|i| leadr.levels[0].texels[i].second.map(f64::from).iter().sum()) / power;
    let agree = (0..truth.len())
        .map(|i| {
            let mean = leadr.levels[0].texels[i].mean_slope.map(f64::from);
            (DVec2::from_array(mean) - schemes[0].1[i]).abs().max_element()
        })
        .fold(0.0, f64::max);
    let picture = studio.picture("figures-differences-0", &shown, 1.0, "the map's own slopes", Vec::new())?;
    let mut table = Table::new(
        format!("{SIDE} × {SIDE} texels, slopes of deviation {SLOPE}"),
        ["", "shaded", "rRMSE of the slopes", "rRMSE of the picture", "E[x² + y²] kept"],
    );
    table.row([
        Cell::from("the map's own slopes"),
        Cell::Figure(picture.enlarged(SCALE)),
        0.0.into(),
        0.0.into(),
        1.0.into(),
    ]);
    let mut listed = Vec::new();
    for (index, (name, slopes)) in schemes.iter().enumerate() {
        let image = shaded(slopes);
        let off = (mean(&|i| (slopes[i] - truth[i]).length_squared()) / power).sqrt();
        let seen = rrmse(&shown, &image).map_err(fault)?;
        let squares = mean(&|i| slopes[i].length_squared()) / power;
        let file = format!("figures-differences-{}", index + 1);
        let picture = studio.picture(&file, &image, 1.0, name, Vec::new())?.enlarged(SCALE);
        table.row([Cell::from(*name), Cell::Figure(picture), off.into(), seen.into(), squares.into()]);
        page.check(format!("rRMSE of the slopes, {name}"), off);
        page.check(format!("rRMSE of the picture, {name}"), seen);
        listed.push(format!("{name} {} ({})", number(off), number(seen)));
    }
    page.html.table(&table);
    page.check("share of E[x² + y²] in the second moments of the LEADR map", kept);
    page.check("largest difference of the mean slopes of LeadrMap", agree);
    page.find(&format!(
        "rRMSE of the slopes, and of the picture: {}. LeadrMap holds the first scheme's mean slopes to {}, and its second moments have {} of E[x² + y²].",
        listed.join(", "),
        number(agree),
        number(kept)
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn central_differences_are_nearer_than_one_sided_ones() {
        let smooth = Smooth::new();
        let truth = smooth.texels(|_, slope| slope);
        let map = HeightMap::new(SIDE, SIDE, smooth.texels(|height, _| height as f32)).unwrap();
        let error = |slopes: &[DVec2]| slopes.iter().zip(&truth).map(|(a, b)| (*a - *b).length_squared()).sum::<f64>();
        let central = slopes_of_heights(&map, 1.0, Wrap::Repeat, Difference::Central);
        let central: Vec<DVec2> = central.texels().iter().map(|s| DVec2::new(s[0].into(), s[1].into())).collect();
        let power: f64 = truth.iter().map(|s| s.length_squared()).sum();
        let deviation = (0.5 * power / truth.len() as f64).sqrt();
        assert!((deviation / SLOPE - 1.0).abs() < 0.1, "{deviation}");
        assert!(error(&central) < 0.25 * error(&pairs(&map)));
        assert!(error(&central) < 0.1 * power);
    }
}
