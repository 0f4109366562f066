//! Draws LEADR Figure 6, which leads from slope samples in one dimension to the distribution.

use glam::{DVec2, DVec3, Vec3Swizzles as _};

use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::slopes::grid::{grid_lambda, grid_node, slope_at, slope_cholesky};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Plot, Scale, Table, number};

/// The mean slope of the target distribution, whose covariance is `(xx, yy, xy)`.
const MEAN: DVec2 = DVec2::new(0.3, -0.2);
const COVARIANCE: DVec3 = DVec3::new(0.16, 0.49, 0.168);
const PAPER: u32 = 5;

fn samples(n: u32) -> Vec<(DVec2, f64)> {
    let (lambda, cholesky) = (grid_lambda(n), slope_cholesky(COVARIANCE));
    let node = |i: u32| grid_node(i / n, i % n, n, lambda);
    (0..n * n).map(node).map(|node| (slope_at(node.xy(), MEAN, cholesky), node.z)).collect()
}

fn moments(samples: &[(DVec2, f64)]) -> (DVec2, DVec3) {
    let sum: f64 = samples.iter().map(|(_, w)| w).sum();
    let mean = samples.iter().map(|(slope, w)| slope * w).sum::<DVec2>() / sum;
    let square = |d: DVec2| DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y);
    (mean, samples.iter().map(|(slope, w)| square(slope - mean) * w).sum::<DVec3>() / sum)
}

pub fn draw(_: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR Figure 6",
        "(a) Five even samples of a normal distribution and their weights; (b) their Cartesian product; (c) the product scaled, \
        correlated and shifted to the target slopes: mean (.3, −.2), deviations .4 and .7, correlation .6.",
    );
    let lambda = grid_lambda(PAPER);
    let mut line = Plot::new("(a) One dimension", ("p", Scale::Linear), ("weight", Scale::Linear));
    let nodes: Vec<DVec3> = (0..PAPER).map(|k| grid_node(PAPER / 2, k, PAPER, lambda)).collect();
    let sum: f64 = nodes.iter().map(|node| node.z).sum();
    line.line("samples", nodes.iter().map(|node| (node.y, node.z / sum)).collect());
    page.html.plot(&line);
    let mut product = Plot::new("(b) Two dimensions", ("p_j", Scale::Linear), ("p_k", Scale::Linear));
    let mut slopes = Plot::new("(c) Slopes", ("slope x", Scale::Linear), ("slope y", Scale::Linear));
    let cholesky = slope_cholesky(COVARIANCE);
    for k in 0..PAPER {
        let row = |at: &dyn Fn(DVec2) -> DVec2| {
            (0..PAPER).map(|j| at(grid_node(j, k, PAPER, lambda).xy())).map(|p| (p.x, p.y)).collect()
        };
        let name = format!("p_k = {}", number(grid_node(0, k, PAPER, lambda).y));
        product.line(&name, row(&|p| p));
        slopes.line(&name, row(&|p| slope_at(p, MEAN, cholesky)));
    }
    page.html.plot(&product);
    page.html.plot(&slopes);
    let mut table = Table::new(
        "Moments of the weighted samples",
        [
            "samples",
            "λ",
            "mean x",
            "mean y",
            "covariance xx",
            "yy",
            "xy",
            "largest error of the mean",
            "share of the covariance",
        ],
    );
    let requested = [MEAN.x, MEAN.y, COVARIANCE.x, COVARIANCE.y, COVARIANCE.z].map(Cell::from);
    table.row(
        [Cell::from("requested"), Cell::from("")].into_iter().chain(requested).chain([Cell::from(""), Cell::from("")]),
    );
    let mut found = Vec::new();
    for n in [3, PAPER, 9, 32, 128] {
        let (mean, covariance) = moments(&samples(n));
        // The grid ends at λ deviations, which reduces all covariance entries by the same factor.
        let (off, share) = ((mean - MEAN).abs().max_element(), covariance.x / COVARIANCE.x);
        let numbers =
            [grid_lambda(n), mean.x, mean.y, covariance.x, covariance.y, covariance.z, off, share].map(Cell::from);
        table.row(std::iter::once(Cell::from(format!("{n}×{n}"))).chain(numbers));
        page.check(format!("error of the mean, {n}×{n}"), off);
        let worst = ((covariance - COVARIANCE) / COVARIANCE).abs().max_element();
        page.check(format!("largest relative error of the covariance, {n}×{n}"), worst);
        found.push(format!("{n}×{n} {}", number(share)));
    }
    page.html.table(&table);
    page.find(&format!(
        "the samples have the target mean to rounding, and this fraction of the covariance (the rest lies beyond λ): {}.",
        found.join(", ")
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_the_mean_and_most_of_the_covariance() {
        let (mean, covariance) = moments(&samples(PAPER));
        let ratio = covariance / COVARIANCE;
        assert!((mean - MEAN).length() < 1e-12);
        assert!((ratio - ratio.x).length() < 1e-9 && (0.8..0.9).contains(&ratio.x), "{ratio}");
        let (_, converged) = moments(&samples(128));
        assert!((converged / COVARIANCE - 1.0).length() < 1e-3, "{converged}");
    }
}
