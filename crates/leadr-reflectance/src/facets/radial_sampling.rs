//! Samples the facets of a radial table by the radius of their slopes (Walter et al. 2007; thesis 4.4, Listings 4.8 and 4.9).
//!
//! The azimuth is uniform. The radius has the distribution
//!
//! ```text
//! F(θ) = 2π ∫₀^θ D(t) cos t sin t dt,   θ = atan r
//! ```
//!
//! Samples do not depend on the viewer, so many of them are hidden at grazing angles. Samples of visible normals
//! ([`SlopeDistribution::sample_visible`]) have less noise, and this scheme is their baseline.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::hermite;
use super::radial_table::{RadialTable, angle_at};
use super::slope_distribution::SlopeDistribution;
use crate::quadrature::gauss_legendre;
use crate::roots::bisect;

/// The number of quadrature points between two nodes.
const ORDER: usize = 4;

/// The distribution of the radius of the slopes of a table.
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
        let rate = |u: f64| {
            let (sine, cosine) = angle_at(u).sin_cos();
            // dθ = π u du
            TAU * PI * u * table.density(angle_at(u)) * sine * cosine / n as f64
        };
        let rule = gauss_legendre(ORDER);
        let mut nodes = vec![(0.0, rate(0.0))];
        for i in 0..n {
            let inside = rule.iter().map(|&(x, w)| 0.5 * w * rate((i as f64 + 0.5 + 0.5 * x) / n as f64));
            nodes.push((nodes[i].0 + inside.sum::<f64>(), rate((i + 1) as f64 / n as f64)));
        }
        let all = nodes[n].0;
        nodes.iter_mut().for_each(|(sum, rate)| (*sum, *rate) = (*sum / all, *rate / all));
        Self { table, nodes }
    }

    /// Returns the angle `θ` whose `F` is `u`, which is in `[0, 1)` (Listing 4.9).
    pub fn quantile(&self, u: f64) -> f64 {
        let n = self.nodes.len() - 1;
        let i = self.nodes.partition_point(|(sum, _)| *sum <= u).clamp(1, n) - 1;
        let ((from, rate_from), (to, rate_to)) = (self.nodes[i], self.nodes[i + 1]);
        let t = if i == 0 {
            // D is nearly constant up to the first node, and F grows as u⁴, faster than a cubic can.
            (u / to).max(0.0).sqrt().sqrt()
        } else {
            bisect(0.0, 1.0, 40, |t| hermite(from, rate_from, to, rate_to, t) < u)
        };
        angle_at((i as f64 + t) / n as f64)
    }

    /// Samples the normal of a facet from `u` in `[0, 1)²`.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let (sine, cosine) = self.quantile(u.x).sin_cos();
        DVec2::from_angle(TAU * u.y).extend(0.0) * sine + DVec3::Z * cosine
    }

    /// Returns the density of the samples per solid angle of normals, `D cos θ`.
    pub fn density(&self, wn: DVec3) -> f64 {
        self.table.ndf(wn) * wn.z.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::chi_square::chi_square;
    use crate::facets::ggx::Ggx;
    use crate::random::Random;

    fn table(alpha: f64) -> RadialTable {
        let at = |i: u32| {
            let (sine, cosine) = angle_at(f64::from(i) / 90.0).sin_cos();
            Ggx::isotropic(DVec2::ZERO, alpha).ndf(DVec3::new(sine, 0.0, cosine))
        };
        RadialTable::new(&(0..90).map(at).collect::<Vec<_>>()).unwrap()
    }

    /// A distribution whose visible normals are drawn from all normals. From above, both are the same.
    struct FromAbove<'a>(RadialSampler<'a>);

    impl SlopeDistribution for FromAbove<'_> {
        fn p22(&self, slope: DVec2) -> f64 {
            self.0.table.p22(slope)
        }

        fn mean_slope(&self) -> DVec2 {
            DVec2::ZERO
        }

        fn shape(&self) -> DVec3 {
            self.0.table.shape()
        }

        fn visible_area(&self, w: DVec3) -> f64 {
            self.0.table.visible_area(w)
        }

        fn sample_visible(&self, _: DVec3, u: DVec2) -> DVec3 {
            self.0.sample(u)
        }
    }

    #[test]
    fn normals_have_their_density() {
        for alpha in [0.05, 0.4] {
            let table = table(alpha);
            let drawn = FromAbove(RadialSampler::new(&table));
            let (found, most) = chi_square(&drawn, &table, DVec3::Z, 40_000);
            let (wrong, _) = chi_square(&drawn, &Ggx::isotropic(DVec2::ZERO, 1.1 * alpha), DVec3::Z, 40_000);
            println!("χ² at α {alpha}: {found:.1}, wrong distribution {wrong:.1}, limit {most:.1}");
            assert!(found < most && wrong > most, "{alpha}: {found} {wrong} {most}");
            let angles = [0.0, 0.5, 0.999_999].map(|u| drawn.0.quantile(u));
            assert!(angles[0] < 1e-6 && (angles[1] - alpha.atan()).abs() < 1e-3 && angles[2] < 0.5 * PI, "{angles:?}");
        }
    }

    /// Both schemes find the same directional albedo of shadowed facets, from above and at a grazing angle, and visible normals have less
    /// noise.
    #[test]
    fn visible_normals_have_less_noise() {
        let table = table(0.4);
        let sampler = RadialSampler::new(&table);
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
                let wn = sampler.sample(u);
                lit(wn) * weight(wn)
            });
            println!("{angle}°: {mean:.4} and {of_all:.4}, variance of one sample {noise:.4} and {noise_of_all:.4}");
            let error = ((noise + noise_of_all) / 4e4).sqrt();
            assert!((mean - of_all).abs() < 4.0 * error, "{angle}: {mean} {of_all} {error}");
            assert!(noise_of_all > gain * noise, "{angle}: {noise} {noise_of_all}");
        }
    }
}
