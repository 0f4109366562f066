//! Draws LEADR Figure 2, which shows the slopes that a viewer sees.

use std::array::from_fn;

use glam::{DVec2, DVec3};

use crate::ray_cast::{Patch, Spectrum, Tile};
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::facets::beckmann::beckmann_p22;
use leadr_reflectance::facets::projected_area::visible_area;
use leadr_reflectance::quadrature::composite_gauss;
use leadr_reflectance::slopes::grid::facet_area;
use leadr_tools::error::LabError;
use leadr_tools::html::{Plot, Scale, Table, number};

/// The standard deviation of the slopes.
const SIGMA: f64 = 0.5;
/// The angles in degrees between the viewer and the mean normal.
const ANGLES: [f64; 3] = [0.0, 45.0, 80.0];
const BINS: usize = 40;
/// The range of the histogram on each side of zero, in standard deviations of the slopes.
const REACH: f64 = 4.0;
/// The number of cells of the profile in the plot.
const SHOWN: usize = 160;

fn bin(k: usize) -> (f64, f64) {
    let edge = |k: usize| SIGMA * REACH * (2.0 * k as f64 / BINS as f64 - 1.0);
    (edge(k), edge(k + 1))
}

fn viewer(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

/// Computes the fraction of the visible area in each bin of the slope along the view: `max(0, wo·(−x, −y, 1)) P22 / A`, integrated over the
/// other slope.
fn predicted(wo: DVec3) -> [f64; BINS] {
    let s = DVec3::new(SIGMA * SIGMA, SIGMA * SIGMA, 0.0);
    let area = visible_area(wo, DVec2::ZERO, s);
    let across = composite_gauss(-6.0 * SIGMA, 6.0 * SIGMA, 12, 4);
    from_fn(|k| {
        let (low, high) = bin(k);
        let along = composite_gauss(low, high, 1, 4);
        let pairs = along.iter().flat_map(|&(x, u)| across.iter().map(move |&(y, v)| (DVec2::new(x, y), u * v)));
        pairs.map(|(slope, w)| w * facet_area(wo, slope) * beckmann_p22(slope, DVec2::ZERO, s)).sum::<f64>() / area
    })
}

/// Counts the fraction of the visible area in each bin, by rays on random surfaces.
fn counted(tiles: &[Tile], wo: DVec3, rays: u32) -> Result<[f64; BINS], LabError> {
    let mut mean = [0.0; BINS];
    for (tile, seed) in tiles.iter().zip(1..) {
        let patch = Patch::new(tile, DVec2::ZERO, DVec3::new(SIGMA * SIGMA, SIGMA * SIGMA, 0.0));
        let seen = patch.mean_over_visible::<BINS>(wo, rays, seed, |facet, _| {
            let at = (facet.slope.x / (SIGMA * REACH) * 0.5 + 0.5) * BINS as f64;
            from_fn(|k| f64::from(at.floor() == k as f64))
        });
        let seen = seen.ok_or_else(|| LabError("nothing is visible to a viewer above the surface".to_owned()))?;
        mean = from_fn(|k| mean[k] + seen.mean[k] / tiles.len() as f64);
    }
    Ok(mean)
}

/// Computes the total variation distance: half of the summed differences, or the largest difference in probability of any
/// event.
fn total_variation(a: &[f64; BINS], b: &[f64; BINS]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// Returns the heights of a row of the tile, and whether each point of the row is visible. A point is hidden if the relief
/// rises above the line of sight.
fn profile(tile: &Tile, degrees: f64) -> (Vec<f64>, Vec<bool>) {
    let row = &tile.heights()[..tile.size() as usize];
    let heights: Vec<f64> = row.iter().map(|&h| SIGMA * f64::from(h)).collect();
    let cot = degrees.to_radians().tan().recip();
    let mut highest = f64::NEG_INFINITY;
    let mut seen: Vec<bool> = heights
        .iter()
        .enumerate()
        .rev()
        .map(|(x, h)| {
            let level = h - x as f64 * cot;
            let seen = level >= highest;
            highest = highest.max(level);
            seen
        })
        .collect();
    seen.reverse();
    (heights, seen)
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR Figure 2",
        "A Gaussian surface with slope deviation .5, seen from 0°, 45° and 80°: distributions of visible slopes from the model and \
        counted by rays. The viewer is on the side of positive x, whose facets have negative slopes. The profile is a cut through the \
        surface; its bold parts are visible to the viewer at 80°.",
    );
    let (count, size, rays) = studio.pick((1, 256, 256), (4, 1024, 1024));
    let tiles: Vec<Tile> = (1..=count).map(|seed| Tile::new(Spectrum::Gaussian, size, 8.0, seed)).collect();
    let (heights, seen) = profile(&tiles[0], ANGLES[2]);
    let mut cut =
        Plot::new("A profile, seen from 80° on the right", ("cells", Scale::Linear), ("height, cells", Scale::Linear));
    let points = |shown: &dyn Fn(usize) -> bool| {
        let at = |x: usize| (x as f64, if shown(x) { heights[x] } else { f64::NAN });
        (0..SHOWN.min(heights.len())).map(at).collect()
    };
    cut.guide("profile", points(&|_| true));
    cut.line("seen from 80°", points(&|x| seen[x]));
    page.html.plot(&cut);
    let mut plot = Plot::new(
        "Visible slopes: model (lines) and counted (dashed)",
        ("slope along the view", Scale::Linear),
        ("density", Scale::Linear),
    );
    let mut table = Table::new(
        "Total variation distance between distributions of the slope along the view, 0 to 1",
        ["angle", "counted – model", "counted – all slopes, visible or not"],
    );
    let all = predicted(DVec3::Z);
    let mut distances = Vec::new();
    for degrees in ANGLES {
        let wo = viewer(degrees);
        let (model, found) = (predicted(wo), counted(&tiles, wo, rays)?);
        let line = |shares: &[f64; BINS]| {
            let at = |k: usize| (0.5 * (bin(k).0 + bin(k).1), shares[k] / (bin(k).1 - bin(k).0));
            (0..BINS).map(at).collect()
        };
        plot.line(&format!("model, {degrees}°"), line(&model));
        plot.guide(&format!("counted, {degrees}°"), line(&found));
        let (distance, blind) = (total_variation(&found, &model), total_variation(&found, &all));
        page.check(format!("total variation distance, {degrees}°"), distance);
        page.check(format!("total variation distance to all slopes, {degrees}°"), blind);
        table.row([format!("{degrees}°").into(), distance.into(), blind.into()]);
        distances.push(format!(
            "{} at {degrees}° ({} if every slope counted as visible)",
            number(distance),
            number(blind)
        ));
    }
    page.html.plot(&plot);
    page.html.table(&table);
    page.find(&format!(
        "the slopes counted by rays have a total variation distance from the model of {}.",
        distances.join(", ")
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_sum_to_one_and_lean_to_the_viewer() {
        let [front, steep] = [0.0, 80.0].map(|degrees| predicted(viewer(degrees)));
        for shares in [&front, &steep] {
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{shares:?}");
        }
        assert!(total_variation(&front, &steep) > 0.3);
        assert!(steep[..BINS / 2].iter().sum::<f64>() > 0.9);
    }

    #[test]
    fn profile_visibility_depends_on_view_angle() {
        let tile = Tile::new(Spectrum::Gaussian, 64, 8.0, 1);
        let seen = |degrees: f64| profile(&tile, degrees).1.iter().filter(|&&seen| seen).count();
        assert_eq!(seen(1.0), 64);
        assert!((1..50).contains(&seen(85.0)), "{}", seen(85.0));
    }
}
