//! Any isotropic slope distribution, tabulated over the angle to the macrosurface normal (thesis 4.2 and 4.4).
//!
//! The table stores `ln D` at angles `θ = u² π/2` for evenly spaced `u`, so nodes are denser near highlights. All distributions of this
//! library have a finite `D` at 90°, so tails extend beyond the last node.
//!
//! All other quantities follow from one integral. In spherical coordinates about the y axis, `wn = (−sin ψ cos χ, sin χ, cos ψ cos χ)`. The
//! slope along x is `tan ψ`, and `cos θ = cos ψ cos χ`. The projected facet area for a viewer `(sin θ_o, 0, cos θ_o)` is
//! `cos χ cos(ψ + θ_o)`. With
//!
//! ```text
//! W(ψ) = ∫ D(cos ψ cos χ) cos² χ dχ,   C(ψ) = ∫₀^ψ W cos,   S(ψ) = ∫₀^ψ W sin
//! ```
//!
//! the visible area is a sum of `C` and `S`. The ratio of a partial sum to the visible area is the cumulative distribution of visible
//! slopes along x. The distribution of the slope along y is the same for all viewers. These are the marginal and the conditional
//! distribution of thesis 4.4. In these coordinates the derivative of the copula is `D cos² χ`, without a quotient of small numbers.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::{Curve, hermite};
use super::slope_distribution::SlopeDistribution;
use crate::quadrature::gauss_legendre;
use crate::roots::bisect;

/// The lower bound of a tabulated normal density, as a fraction of the largest density.
pub const LEAST_SHARE: f64 = 1e-30;
/// The number of quadrature points between two nodes.
const ORDER: usize = 4;
/// The number of intervals of the marginal distribution per table interval.
const FINER: usize = 2;
/// The number of azimuths over which a function of the slope is averaged.
const AZIMUTHS: u32 = 256;
/// The number of quadrature panels over the angle χ.
const PANELS: usize = 96;

/// A tabulated isotropic slope distribution, normalised to `∫ D cos θ dω = 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialTable {
    /// The curve of `ln D` over `u`.
    ln_d: Curve,
    /// The nodes of the marginal distribution, from ψ = 0 to 90°.
    marginal: Vec<Marginal>,
    /// The variance of the tabulated slopes per axis.
    variance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Marginal {
    psi: f64,
    /// The value of `W(ψ)`.
    w: f64,
    cosine: f64,
    sine: f64,
}

/// Returns the angle `θ` at the table coordinate `u`.
pub fn angle_at(u: f64) -> f64 {
    u * u * FRAC_PI_2
}

/// Returns the table coordinate `u` of the angle `θ`.
pub fn u_of_angle(theta: f64) -> f64 {
    (theta.max(0.0) / FRAC_PI_2).sqrt()
}

/// Returns the nodes `(θ, weight)` of a quadrature rule for `∫ f(θ) dθ` from 0 to 90°. The rule is accurate if `f` is smooth between nodes.
pub fn angle_rule(nodes: usize) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(ORDER);
    let half = 0.5 / nodes as f64;
    (0..nodes)
        .flat_map(|i| rule.iter().map(move |&(x, w)| ((2 * i + 1) as f64 * half + half * x, half * w)))
        .map(|(u, w)| (angle_at(u), w * PI * u))
        .collect()
}

/// Returns the logarithms of at least two densities relative to `largest`, plus an extrapolated value at 90°. The extrapolation never
/// rises, because the last measured angle is the noisiest. NaN counts as 0.
pub fn logarithms(densities: &[f64], largest: f64) -> Vec<f64> {
    let least = LEAST_SHARE.ln();
    let ln = |&d: &f64| if d.is_finite() { (d / largest).max(LEAST_SHARE).ln() } else { least };
    let mut all: Vec<f64> = densities.iter().map(ln).collect();
    let n = all.len();
    all.push((2.0 * all[n - 1] - all[n - 2]).clamp(least, all[n - 1]));
    all
}

impl RadialTable {
    /// Builds a table from `n` normal densities at `u = i / n`, which are known up to a common factor. The value at 90° is extrapolated.
    /// Negative values and NaN count as 0.
    ///
    /// Returns `None` if there are fewer than 3 values, or if no value is above 0.
    pub fn new(densities: &[f64]) -> Option<Self> {
        let n = densities.len();
        let largest = densities.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        if n < 3 || largest <= 0.0 {
            return None;
        }
        let mut ln = logarithms(densities, largest);
        let shape = Curve::new(ln.clone());
        let sum: f64 =
            angle_rule(n).into_iter().map(|(theta, w)| w * density(&shape, theta) * theta.sin() * theta.cos()).sum();
        let scale = -(TAU * sum).ln();
        ln.iter_mut().for_each(|value| *value += scale);
        let ln_d = Curve::new(ln);
        let marginal = marginal(&ln_d);
        let variance = angle_rule(n)
            .into_iter()
            .map(|(theta, w)| w * density(&ln_d, theta) * theta.sin().powi(3) / theta.cos())
            .sum::<f64>()
            * PI;
        Some(Self { ln_d, marginal, variance })
    }

    /// Returns the number of input values.
    pub fn nodes(&self) -> usize {
        self.ln_d.values().len() - 1
    }

    /// Returns the curve of `ln D` over `u`. Each step of the curve is one node.
    pub fn ln_d(&self) -> &Curve {
        &self.ln_d
    }

    /// Returns `D` at the angle `theta` to the macrosurface normal.
    pub fn density(&self, theta: f64) -> f64 {
        density(&self.ln_d, theta)
    }

    /// Returns the slope variance per axis, `∫ x² P22` over the tabulated slopes. The result is finite even if the surface has infinite
    /// variance.
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Integrates `f(slope) P22` over the tabulated slopes.
    pub fn mean_of(&self, f: impl Fn(DVec2) -> f64) -> f64 {
        let step = TAU / f64::from(AZIMUTHS);
        let ring = |(theta, w): (f64, f64)| {
            let at = |k| f(-theta.tan() * DVec2::from_angle(step * (f64::from(k) + 0.5)));
            w * theta.sin() * theta.cos() * step * self.density(theta) * (0..AZIMUTHS).map(at).sum::<f64>()
        };
        angle_rule(self.nodes()).into_iter().map(ring).sum()
    }

    /// Returns the integrals `C` and `S` at a positive or negative angle ψ.
    fn sums(&self, psi: f64) -> (f64, f64) {
        let (i, t, width) = self.interval(psi.abs());
        let (a, b) = (&self.marginal[i], &self.marginal[i + 1]);
        let part = |a0, wa: f64, b0, wb: f64| hermite(a0, wa * width, b0, wb * width, t);
        let c = part(a.cosine, a.w * a.psi.cos(), b.cosine, b.w * b.psi.cos());
        let s = part(a.sine, a.w * a.psi.sin(), b.sine, b.w * b.psi.sin());
        (c.copysign(psi), s)
    }

    fn interval(&self, psi: f64) -> (usize, f64, f64) {
        let n = self.marginal.len() - 1;
        let i = ((u_of_angle(psi) * n as f64) as usize).min(n - 1);
        let (a, b) = (self.marginal[i].psi, self.marginal[i + 1].psi);
        (i, ((psi - a) / (b - a)).clamp(0.0, 1.0), b - a)
    }
}

fn density(ln_d: &Curve, theta: f64) -> f64 {
    ln_d.at(u_of_angle(theta) * (ln_d.values().len() - 1) as f64).exp()
}

/// Computes `∫₀^χ D(cos ψ cos χ) cos² χ dχ` at the end of each panel by Simpson's rule. Each value comes with its derivative per panel.
fn across(ln_d: &Curve, psi: f64) -> Vec<(f64, f64)> {
    let (sin_psi, cos_psi) = psi.sin_cos();
    let at = |panel: f64| {
        let v = panel / PANELS as f64;
        let (sine, cosine) = angle_at(v).sin_cos();
        // Computing the angle from the sine keeps small angles precise.
        let theta = sine.hypot(cosine * sin_psi).atan2(cosine * cos_psi);
        density(ln_d, theta) * cosine * cosine * PI * v / PANELS as f64
    };
    let mut sums = vec![(0.0, at(0.0))];
    for i in 0..PANELS {
        let (sum, before) = sums[i];
        let after = at((i + 1) as f64);
        sums.push((sum + (before + 4.0 * at(i as f64 + 0.5) + after) / 6.0, after));
    }
    sums
}

fn marginal(ln_d: &Curve) -> Vec<Marginal> {
    let n = (ln_d.values().len() - 1) * FINER;
    let w = |psi: f64| 2.0 * across(ln_d, psi)[PANELS].0;
    let mut nodes = vec![Marginal { psi: 0.0, w: w(0.0), cosine: 0.0, sine: 0.0 }];
    let rule = gauss_legendre(3);
    for i in 0..n {
        let Marginal { mut cosine, mut sine, .. } = nodes[i];
        for &(x, weight) in &rule {
            let u = (i as f64 + 0.5 + 0.5 * x) / n as f64;
            let psi = angle_at(u);
            let part = 0.5 * weight / n as f64 * PI * u * w(psi);
            cosine += part * psi.cos();
            sine += part * psi.sin();
        }
        let psi = angle_at((i + 1) as f64 / n as f64);
        nodes.push(Marginal { psi, w: w(psi), cosine, sine });
    }
    // Normalise the integral of D cos θ to one.
    let scale = 0.5 / nodes[n].cosine;
    nodes.iter_mut().for_each(|node| {
        node.w *= scale;
        node.cosine *= scale;
        node.sine *= scale;
    });
    nodes
}

impl SlopeDistribution for RadialTable {
    fn p22(&self, slope: DVec2) -> f64 {
        let r2 = slope.length_squared();
        self.density(r2.sqrt().atan()) / ((1.0 + r2) * (1.0 + r2))
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        if wn.z <= 0.0 { 0.0 } else { self.density(wn.truncate().length().atan2(wn.z)) }
    }

    fn mean_slope(&self) -> DVec2 {
        DVec2::ZERO
    }

    fn shape(&self) -> DVec3 {
        DVec3::new(self.variance, self.variance, 0.0)
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        let (sine, cosine) = (w.truncate().length(), w.z);
        // Facets with ψ from −90° to 90° − θ_o face w. The sines change sign, because ψ increases away from w.
        let (c, s) = self.sums(cosine.atan2(sine));
        let end = self.marginal[self.marginal.len() - 1];
        (cosine * (c + end.cosine) + sine * (end.sine - s)).max(cosine.max(0.0))
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let sine = wo.truncate().length();
        let area = self.visible_area(wo);
        let end = self.marginal[self.marginal.len() - 1];
        // The visible area of the slopes up to ψ along wo's azimuth.
        let before = |psi: f64| {
            let (c, s) = self.sums(psi);
            wo.z * (c + end.cosine) + sine * (end.sine - s)
        };
        let psi = bisect(-FRAC_PI_2, wo.z.atan2(sine), 50, |psi| before(psi) < u.x * area);
        // Sample the slope across wo's azimuth, with either sign.
        let v = 2.0 * u.y - 1.0;
        let sums = across(&self.ln_d, psi);
        let wanted = v.abs() * sums[PANELS].0;
        let i = sums.partition_point(|(sum, _)| *sum <= wanted).clamp(1, PANELS) - 1;
        let ((from, rate_from), (to, rate_to)) = (sums[i], sums[i + 1]);
        let t = bisect(0.0, 1.0, 30, |t| hermite(from, rate_from, to, rate_to, t) < wanted);
        let chi = angle_at((i as f64 + t) / PANELS as f64).copysign(v);
        let (sin_psi, cos_psi) = psi.sin_cos();
        let (sin_chi, cos_chi) = chi.sin_cos();
        let along = if sine > 1e-12 { wo.truncate() / sine } else { DVec2::X };
        along.rotate(DVec2::new(-sin_psi * cos_chi, sin_chi)).extend(cos_psi * cos_chi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::Beckmann;
    use crate::facets::chi_square::chi_square;
    use crate::facets::ggx::Ggx;

    fn table(of: &impl SlopeDistribution, n: usize) -> RadialTable {
        let at = |i: usize| {
            let (sine, cosine) = angle_at(i as f64 / n as f64).sin_cos();
            of.ndf(DVec3::new(sine, 0.0, cosine))
        };
        RadialTable::new(&(0..n).map(at).collect::<Vec<_>>()).unwrap()
    }

    fn directions() -> Vec<DVec3> {
        let mut all = Vec::new();
        for theta in [0.0, 0.3, 0.9, 1.3, 1.5, 1.5607, 1.6, 1.9, 2.8] {
            for phi in [0.0f64, 1.1, 4.0] {
                let (sine, cosine) = f64::sin_cos(theta);
                all.push(DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine));
            }
        }
        all
    }

    fn compare(of: &impl SlopeDistribution, n: usize) -> [f64; 2] {
        let table = table(of, n);
        let (mut ndf, mut area) = (0.0f64, 0.0f64);
        for w in directions() {
            ndf = ndf.max((table.ndf(w) - of.ndf(w)).abs() / of.ndf(DVec3::Z));
            let (a, b) = (table.visible_area(w), of.visible_area(w));
            area = area.max((a - b).abs() / b.max(0.05));
        }
        [ndf, area]
    }

    #[test]
    fn a_table_of_an_analytic_distribution_is_that_distribution() {
        // `most` bounds the density error, relative to the largest density, and the relative area error. A coarse table must exceed it.
        for (alpha, most) in [(0.01, 3e-5), (0.03, 5e-6), (0.1, 1e-5), (0.3, 1e-4), (0.8, 6e-4)] {
            let variance = 0.5 * alpha * alpha;
            let gaussian = Beckmann::new(DVec2::ZERO, DVec3::new(variance, variance, 0.0));
            let ggx = Ggx::isotropic(DVec2::ZERO, alpha);
            for [ndf, area] in [compare(&gaussian, 90), compare(&ggx, 90)] {
                assert!(ndf < most && area < most, "{alpha}: {ndf:e} {area:e}");
            }
            let found = table(&gaussian, 90).variance() / variance - 1.0;
            assert!(found.abs() < 3e-6, "{alpha}: {found:e}");
            let found = table(&ggx, 90).mean_of(|s| s.x.abs()) / alpha - 1.0;
            assert!(found.abs() < 1e-4, "{alpha}: {found:e}");
        }
        let [coarse, _] = compare(&Ggx::isotropic(DVec2::ZERO, 0.01), 12);
        assert!(coarse > 1e-3, "{coarse:e}");
    }

    #[test]
    fn visible_normals_have_their_density() {
        let table = table(&Ggx::isotropic(DVec2::ZERO, 0.4), 90);
        for theta in [0.0, 0.8, 1.45f64] {
            let wo = DVec3::new(theta.sin() * 0.6, -theta.sin() * 0.8, theta.cos());
            let (found, most) = chi_square(&table, &table, wo, 40_000);
            let (wrong, _) = chi_square(&table, &Ggx::isotropic(DVec2::ZERO, 0.43), wo, 40_000);
            println!("χ² at {theta}: {found:.1}, wrong distribution {wrong:.1}, limit {most:.1}");
            assert!(found < most && wrong > most, "{theta}: {found} {wrong} {most}");
        }
    }

    #[test]
    fn empty_tables_are_refused() {
        assert_eq!(RadialTable::new(&[1.0, 0.5]), None);
        assert_eq!(RadialTable::new(&[0.0, -1.0, f64::NAN]), None);
        let odd = RadialTable::new(&[f64::INFINITY, 1.0, f64::NAN, -3.0, 0.2]).unwrap();
        for w in directions() {
            assert!(odd.visible_area(w).is_finite() && odd.ndf(w).is_finite());
            let wn = odd.sample_visible(w, DVec2::new(0.999_999, 0.0));
            assert!((wn.length() - 1.0).abs() < 1e-9, "{w} {wn}");
        }
    }
}
