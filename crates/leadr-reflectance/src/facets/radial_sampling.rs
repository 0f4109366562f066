//! Samples the facets of a table in polar coordinates of their slopes (Walter et al. 2007; thesis 4.3 and 4.4).
//!
//! For a radial table, the azimuth is uniform. The radius has the distribution (Listings 4.8 and 4.9)
//!
//! ```text
//! F(θ) = 2π ∫₀^θ D(t) cos t sin t dt,   θ = atan r
//! ```
//!
//! For an anisotropic table, the azimuth has a marginal distribution, and the radius has one conditional distribution per azimuth.
//!
//! Samples do not depend on the viewer, so many of them are hidden at grazing angles. Samples of visible normals
//! ([`SlopeDistribution::sample_visible`]) have less noise, and these schemes are their baseline.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::hermite;
use super::polar_table::PolarTable;
use super::radial_table::{RadialTable, angle_at};
use super::slope_distribution::SlopeDistribution;
use crate::quadrature::gauss_legendre;
use crate::roots::bisect;

/// The number of quadrature points between two nodes.
const ORDER: usize = 4;
/// The number of azimuths of a [`PolarSampler`] per azimuth of its table. The mass between two azimuths is interpolated linearly.
const FINER: usize = 4;

/// Integrates `rate(u)` from 0 to each of the nodes `u = i / n`. Returns the integral and its change per node.
fn cumulative(n: usize, rate: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let rate = |u: f64| rate(u) / n as f64;
    let rule = gauss_legendre(ORDER);
    let mut nodes = vec![(0.0, rate(0.0))];
    for i in 0..n {
        let inside = rule.iter().map(|&(x, w)| 0.5 * w * rate((i as f64 + 0.5 + 0.5 * x) / n as f64));
        nodes.push((nodes[i].0 + inside.sum::<f64>(), rate((i + 1) as f64 / n as f64)));
    }
    nodes
}

/// Returns the `u` at which a [`cumulative`] integral, given by its `n + 1` nodes, is `sum`.
fn invert(n: usize, node: impl Fn(usize) -> (f64, f64), sum: f64) -> f64 {
    let (mut i, mut end) = (0, n);
    while end - i > 1 {
        let middle = (i + end) / 2;
        if node(middle).0 <= sum { i = middle } else { end = middle }
    }
    let ((from, rate_from), (to, rate_to)) = (node(i), node(i + 1));
    let t = if i == 0 {
        // D is nearly constant up to the first node, and the mass grows as u⁴, faster than a cubic can.
        (sum / to).clamp(0.0, 1.0).sqrt().sqrt()
    } else {
        bisect(0.0, 1.0, 40, |t| hermite(from, rate_from, to, rate_to, t) < sum)
    };
    (i as f64 + t) / n as f64
}

/// The distribution of the radius of the slopes of a radial table.
#[derive(Clone, Debug)]
pub struct RadialSampler<'a> {
    table: &'a RadialTable,
    /// `F` and its derivative by node, at evenly spaced `u` of `θ = u² π/2`.
    nodes: Vec<(f64, f64)>,
}

impl<'a> RadialSampler<'a> {
    /// Sums the distribution of a table (Listing 4.8).
    pub fn new(table: &'a RadialTable) -> Self {
        let n = table.nodes();
        let mut nodes = cumulative(n, |u| {
            let (sine, cosine) = angle_at(u).sin_cos();
            // dθ = π u du
            TAU * PI * u * table.density(angle_at(u)) * sine * cosine
        });
        let all = nodes[n].0;
        nodes.iter_mut().for_each(|(sum, rate)| (*sum, *rate) = (*sum / all, *rate / all));
        Self { table, nodes }
    }

    /// Returns the angle `θ` whose `F` is `u`, which is in `[0, 1)` (Listing 4.9).
    pub fn quantile(&self, u: f64) -> f64 {
        angle_at(invert(self.nodes.len() - 1, |i| self.nodes[i], u))
    }

    /// Samples the normal of a facet from `u` in `[0, 1)²`.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        normal(self.quantile(u.x), TAU * u.y)
    }

    /// Returns the density of the samples per solid angle of normals, `D cos θ`.
    pub fn density(&self, wn: DVec3) -> f64 {
        self.table.ndf(wn) * wn.z.max(0.0)
    }
}

/// The distribution of the azimuth and of the radius of the slopes of an anisotropic table (the 2D quantile tables of thesis 4.3).
#[derive(Clone, Debug)]
pub struct PolarSampler<'a> {
    table: &'a PolarTable,
    /// The share of the facets before each azimuth.
    marginal: Vec<f64>,
    /// The mass up to each `u` and its change per node, for each azimuth. The last azimuth is the first one again.
    radii: Vec<Vec<(f64, f64)>>,
}

impl<'a> PolarSampler<'a> {
    /// Sums the distributions of a table.
    pub fn new(table: &'a PolarTable) -> Self {
        let (n, azimuths) = table.nodes();
        let steps = FINER * azimuths;
        let of = |k: usize| cumulative(n, |u| table.mass(u, TAU * (k % steps) as f64 / steps as f64));
        let radii: Vec<Vec<(f64, f64)>> = (0..=steps).map(of).collect();
        let mut marginal = vec![0.0];
        for pair in radii.windows(2) {
            marginal.push(marginal[marginal.len() - 1] + pair[0][n].0 + pair[1][n].0);
        }
        let all = marginal[steps];
        marginal.iter_mut().for_each(|sum| *sum /= all);
        Self { table, marginal, radii }
    }

    /// Samples the normal of a facet from `u` in `[0, 1)²`. The azimuth follows from `u.y`, and the angle from `u.x`.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let steps = self.radii.len() - 1;
        let k = self.marginal.partition_point(|sum| *sum <= u.y).clamp(1, steps) - 1;
        let within = (u.y - self.marginal[k]) / (self.marginal[k + 1] - self.marginal[k]);
        let (before, after) = (&self.radii[k], &self.radii[k + 1]);
        let n = before.len() - 1;
        // The mass is linear between two azimuths, so t solves a t + (b − a) t²/2 = (a + b)/2 within.
        let (a, b) = (before[n].0, after[n].0);
        let t = within * (a + b) / (a + (a * a + within * (b * b - a * a)).max(0.0).sqrt());
        let node = |i: usize| {
            let (x, y) = (DVec2::from(before[i]), DVec2::from(after[i]));
            x.lerp(y, t).into()
        };
        let radius = invert(n, node, u.x * node(n).0);
        normal(angle_at(radius), TAU * (k as f64 + t) / steps as f64)
    }

    /// Returns the density of the samples per solid angle of normals, `D cos θ`.
    pub fn density(&self, wn: DVec3) -> f64 {
        self.table.ndf(wn) * wn.z.max(0.0)
    }
}

fn normal(theta: f64, phi: f64) -> DVec3 {
    let (sine, cosine) = theta.sin_cos();
    DVec2::from_angle(phi).extend(0.0) * sine + DVec3::Z * cosine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::chi_square::chi_square;
    use crate::facets::ellipse::{Bivariate, roughness_from_bivariate};
    use crate::facets::ggx::Ggx;
    use crate::random::Random;

    fn table(alpha: f64) -> RadialTable {
        let at = |i: u32| {
            let (sine, cosine) = angle_at(f64::from(i) / 90.0).sin_cos();
            Ggx::isotropic(DVec2::ZERO, alpha).ndf(DVec3::new(sine, 0.0, cosine))
        };
        RadialTable::new(&(0..90).map(at).collect::<Vec<_>>()).unwrap()
    }

    fn anisotropic(alpha: DVec2) -> Ggx {
        Ggx::new(DVec2::ZERO, roughness_from_bivariate(&Bivariate::new(alpha, -0.4)))
    }

    fn polar_table(of: &Ggx) -> PolarTable {
        let at = |i: usize, k: usize| of.ndf(normal(angle_at(i as f64 / 60.0), TAU * k as f64 / 60.0));
        let rows: Vec<Vec<f64>> = (0..60).map(|k| (0..60).map(|i| at(i, k)).collect()).collect();
        PolarTable::new(&rows).unwrap()
    }

    /// A distribution whose visible normals are drawn from all normals. From above, both are the same.
    struct FromAbove<'a>(&'a dyn SlopeDistribution, &'a dyn Fn(DVec2) -> DVec3);

    impl SlopeDistribution for FromAbove<'_> {
        fn p22(&self, slope: DVec2) -> f64 {
            self.0.p22(slope)
        }

        fn mean_slope(&self) -> DVec2 {
            self.0.mean_slope()
        }

        fn shape(&self) -> DVec3 {
            self.0.shape()
        }

        fn visible_area(&self, w: DVec3) -> f64 {
            self.0.visible_area(w)
        }

        fn sample_visible(&self, _: DVec3, u: DVec2) -> DVec3 {
            self.1(u)
        }
    }

    #[test]
    fn normals_have_their_density() {
        for alpha in [0.05, 0.4] {
            let table = table(alpha);
            let sampler = RadialSampler::new(&table);
            let drawn = FromAbove(&table, &|u| sampler.sample(u));
            let (found, most) = chi_square(&drawn, &table, DVec3::Z, 40_000);
            let (wrong, _) = chi_square(&drawn, &Ggx::isotropic(DVec2::ZERO, 1.1 * alpha), DVec3::Z, 40_000);
            println!("χ² at α {alpha}: {found:.1}, wrong distribution {wrong:.1}, limit {most:.1}");
            assert!(found < most && wrong > most, "{alpha}: {found} {wrong} {most}");
            let angles = [0.0, 0.5, 0.999_999].map(|u| sampler.quantile(u));
            assert!(angles[0] < 1e-6 && (angles[1] - alpha.atan()).abs() < 1e-3 && angles[2] < 0.5 * PI, "{angles:?}");
        }
    }

    #[test]
    fn anisotropic_normals_have_their_density() {
        for alpha in [DVec2::new(0.05, 0.2), DVec2::new(0.4, 0.15)] {
            let table = polar_table(&anisotropic(alpha));
            let sampler = PolarSampler::new(&table);
            let drawn = FromAbove(&table, &|u| sampler.sample(u));
            let (found, most) = chi_square(&drawn, &table, DVec3::Z, 40_000);
            let (wrong, _) = chi_square(&drawn, &anisotropic(1.1 * alpha), DVec3::Z, 40_000);
            println!("χ² at α {alpha}: {found:.1}, wrong distribution {wrong:.1}, limit {most:.1}");
            assert!(found < most && wrong > most, "{alpha}: {found} {wrong} {most}");
        }
    }

    /// Both schemes find the same directional albedo of shadowed facets, from above and at a grazing angle, and visible normals have less
    /// noise.
    fn compare(table: &dyn SlopeDistribution, sample: &dyn Fn(DVec2) -> DVec3) {
        let smith = |w: DVec3| w.z / table.visible_area(w);
        for (angle, gain) in [(20.0f64, 1.1), (75.0, 4.0)] {
            let (sine, cosine) = angle.to_radians().sin_cos();
            let wo = DVec3::new(sine, 0.0, cosine);
            let lit = |wn: DVec3| {
                let wi = 2.0 * wo.dot(wn) * wn - wo;
                if wi.z > 0.0 && wo.dot(wn) > 0.0 { smith(wi) } else { 0.0 }
            };
            let moments = |value: &dyn Fn(DVec2) -> f64| {
                let draw = |i: u64| {
                    let mut random = Random::stream(3, i);
                    value(DVec2::new(random.unit(), random.unit()))
                };
                let (sum, squares) =
                    (0..40_000).map(draw).fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
                let mean = sum / 4e4;
                (mean, squares / 4e4 - mean * mean)
            };
            let (mean, noise) = moments(&|u| lit(table.sample_visible(wo, u)));
            // The weight of a normal is its visible area over its density.
            let weight = |wn: DVec3| wo.dot(wn).max(0.0) / (wn.z * table.visible_area(wo));
            let (of_all, noise_of_all) = moments(&|u| {
                let wn = sample(u);
                lit(wn) * weight(wn)
            });
            println!("{angle}°: {mean:.4} and {of_all:.4}, variance of one sample {noise:.4} and {noise_of_all:.4}");
            let error = ((noise + noise_of_all) / 4e4).sqrt();
            assert!((mean - of_all).abs() < 4.0 * error, "{angle}: {mean} {of_all} {error}");
            assert!(noise_of_all > gain * noise, "{angle}: {noise} {noise_of_all}");
        }
    }

    #[test]
    fn visible_normals_have_less_noise() {
        let table = table(0.4);
        let sampler = RadialSampler::new(&table);
        compare(&table, &|u| sampler.sample(u));
    }

    #[test]
    fn visible_anisotropic_normals_have_less_noise() {
        let table = polar_table(&anisotropic(DVec2::new(0.4, 0.3)));
        let sampler = PolarSampler::new(&table);
        compare(&table, &|u| sampler.sample(u));
    }
}
