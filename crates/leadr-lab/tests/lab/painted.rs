//! Tests painted relief by ray casts. The visible lit colour is compared with a closed form and with the mean colour.

use glam::{DVec2, DVec3};
use leadr_lab::ray_cast::{Patch, Spectrum, Tile};
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::slope_cholesky;
use leadr_reflectance::visible::relief_color::{
    ReliefColor, height_weights, lit_slopes_score, relief_color, seen_height, slopes_change,
};

use leadr_testing::standard::direction;

const SIZE: u32 = 512;

/// The region that is painted white on black.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Paint {
    /// The highest part of the relief, as a fraction of the heights.
    Tops(f64),
    /// The lowest part of the relief, as a fraction of the heights.
    Cracks(f64),
    /// The slopes that rise towards +x.
    RainSide,
}

struct Painted {
    tile: Tile,
    colors: Vec<f64>,
    mean: f64,
    relief: ReliefColor,
}

impl Painted {
    /// Creates the paint on slopes of deviation `sigma`.
    fn new(paint: Paint, sigma: f64) -> Self {
        let tile = Tile::new(Spectrum::Gaussian, SIZE, 10.0, 3);
        let heights = tile.heights();
        let mut order: Vec<usize> = (0..heights.len()).collect();
        order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        let mut ranks = vec![0.0; heights.len()];
        for (at, &texel) in order.iter().enumerate() {
            ranks[texel] = (at as f64 + 0.5) / heights.len() as f64;
        }
        let (n, count) = (SIZE as usize, heights.len() as f64);
        let slope = |i: usize, axis: usize| {
            let (x, y) = (i % n, i / n);
            let at = |x: usize, y: usize| f64::from(heights[(y % n) * n + x % n]);
            let rise = if axis == 0 { at(x + 1, y) - at(x + n - 1, y) } else { at(x, y + 1) - at(x, y + n - 1) };
            0.5 * rise * sigma
        };
        let colors: Vec<f64> = (0..heights.len())
            .map(|i| {
                f64::from(match paint {
                    Paint::Tops(share) => ranks[i] > 1.0 - share,
                    Paint::Cracks(share) => ranks[i] < share,
                    Paint::RainSide => slope(i, 0) > 0.0,
                })
            })
            .collect();
        let mean_of = |f: &dyn Fn(usize) -> f64| (0..colors.len()).map(|i| colors[i] * f(i)).sum::<f64>() / count;
        let mean = mean_of(&|_| 1.0);
        let [low, high] = [0, 1].map(|k| DVec3::splat(mean_of(&|i| height_weights(ranks[i])[k]) - mean));
        let [x, y] = [0, 1].map(|axis| DVec3::splat(mean_of(&|i| slope(i, axis))));
        Self { tile, colors, mean, relief: ReliefColor { low, high, x, y } }
    }

    fn at(&self, over: DVec2) -> f64 {
        let n = i64::from(SIZE);
        let cell = |v: f64| (v.round() as i64).rem_euclid(n) as usize;
        self.colors[cell(over.y) * SIZE as usize + cell(over.x)]
    }

    /// Returns the visible lit colour from ray casts, and from the closed form.
    fn colors(&self, sigma: f64, wo: DVec3, wi: DVec3) -> [f64; 2] {
        let s = self.tile.covariance() * sigma * sigma;
        let patch = Patch::new(&self.tile, DVec2::ZERO, s);
        let seen = patch.mean_over_visible(wo, 300, 1, |facet, _| {
            let light = facet.normal.dot(wi).max(0.0);
            let light = if light > 0.0 && patch.is_lit(facet, wi) { light } else { 0.0 };
            [light, light * self.at(facet.over())]
        });
        let [light, painted] = seen.unwrap().mean;
        let cholesky = slope_cholesky(s);
        let (o, i) = (direction_area(wo, DVec2::ZERO, cholesky), direction_area(wi, DVec2::ZERO, cholesky));
        let height = seen_height(&o, lit_fraction(Shadowing::Correlated, &o, &i));
        let change = slopes_change(&self.relief, &lit_slopes_score(wo, wi, DVec2::ZERO, s), s);
        [painted / light, relief_color(DVec3::splat(self.mean), &self.relief, height, change).x]
    }
}

/// Returns the RMS errors of the closed form and of the mean colour. Views are from 15 to 80 degrees, and lights are on all
/// sides.
fn errors(paint: Paint, sigma: f64) -> [f64; 2] {
    let painted = Painted::new(paint, sigma);
    let (mut ours, mut of_mean, mut count) = (0.0, 0.0, 0.0);
    for theta in [15.0, 30.0, 45.0, 60.0, 70.0, 80.0] {
        for (theta_i, phi) in [(30.0, 0.0), (60.0, 90.0), (45.0, 180.0), (75.0, 40.0)] {
            let [want, got] = painted.colors(sigma, direction(theta, 30.0), direction(theta_i, 30.0 + phi));
            println!(
                "{paint:?}, σ {sigma}, {theta}°, light {theta_i}° at {phi}°: {got:.3} instead of {want:.3}, mean {:.3}",
                painted.mean
            );
            ours += (got - want).powi(2);
            of_mean += (painted.mean - want).powi(2);
            count += 1.0;
        }
    }
    let errors = [ours, of_mean].map(|sum: f64| (sum / count).sqrt());
    println!(
        "{paint:?}, σ {sigma}: {:.4} against {:.4} of the mean, {:.2}",
        errors[0],
        errors[1],
        errors[0] / errors[1]
    );
    errors
}

#[test]
#[ignore = "long"]
fn paint_matches_ray_casts() {
    for (paint, sigma, part) in [
        (Paint::Tops(0.3), 0.5, 0.19),
        (Paint::Tops(0.3), 1.0, 0.19),
        (Paint::Cracks(0.3), 0.5, 0.22),
        (Paint::RainSide, 0.5, 0.06),
    ] {
        let [ours, of_mean] = errors(paint, sigma);
        assert!(ours < part * of_mean, "{paint:?}, σ {sigma}: {ours} of {of_mean}");
    }
}
