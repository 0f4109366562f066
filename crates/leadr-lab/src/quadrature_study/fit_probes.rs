//! Fits the wide-lobe rings of [`visible_specular`](leadr_reflectance::visible::specular) by least squares. The targets are
//! random rough surfaces under point lights and random lobes, with and without shadows.
//!
//! The free parameters are the radius, weight and cover of each wide-lobe ring and the kernels' fraction. Narrow lobes are
//! fixed. Every surface is lit by [`POINTS`] point lights, one at a time, from directions that the surface reflects. The
//! reflected lobe is the truth, and errors are relative to the RMS of the reflected lobe. A light without width shows every
//! pattern that a rule leaves. The fit also minimises errors of six radiance lobes, the lit fraction of a white room, and
//! the mean Fresnel term.
//!
//! The command is `cargo run --release --example 12_fit_probes`.

use super::specular::{Lobes, Sharpness};
use super::surfaces::{Surface, rough_surfaces, spherical, surfaces};
use crate::least_squares::least_squares;
use glam::{DVec2, DVec3};
use leadr_reflectance::integrals::reference::{visible_extents, visible_mean_panels};
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{facet_area, normal_of_slope, slope_at, slope_cholesky};
use leadr_reflectance::visible::shadowed_specular::lit_probe;
use leadr_reflectance::visible::slopes::visible_slopes;
use leadr_reflectance::visible::specular::{ProbeKernel, ProbeRing, ProbeRule, visible_probe, visible_probes};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The number of point lights per surface.
pub const POINTS: usize = 10;
/// The weights of the errors: for one point light and for lobes, each without and with shadows, then for the lit fraction of
/// a white room and the Fresnel term.
const FACTORS: [f64; 6] = [0.1, 1.5, 0.4, 6.0, 4.0, 5.0];

/// Computes the density per steradian of directions that are reflected about `wi`, and the lit fraction.
pub fn reflected_density(surface: &Surface, wi: DVec3) -> [f64; 2] {
    let Surface { wo, m, s } = *surface;
    let h = wo + wi;
    if h.z <= 1e-9 {
        return [0.0; 2];
    }
    let slope = DVec2::new(-h.x, -h.y) / h.z;
    if facet_area(wo, slope) <= 0.0 {
        return [0.0; 2];
    }
    let seen = visible_slopes(wo, m, s);
    let (d, c) = (slope - seen.m, slope_cholesky(seen.s));
    let x = d.x / c.x;
    let y = (d.y - c.y * x) / c.z;
    let square = 1.0 + slope.length_squared();
    let density = (-0.5 * (x * x + y * y)).exp() / (TAU * c.x * c.z) * square * square / (4.0 * seen.area);
    let area = |w| direction_area(w, seen.m, c);
    [density, density * lit_fraction(Shadowing::Correlated, &area(wo), &area(wi))]
}

/// Evaluates a kernel of this variance, per steradian. `cosine` is the cosine of the angle from the kernel's axis.
pub fn kernel(variance: f64, cosine: f64) -> f64 {
    let k = Lobes::of_variance(variance.max(1e-7));
    k / (TAU * (1.0 - (-2.0 * k).exp())) * (k * (cosine - 1.0)).exp()
}

struct Item {
    surface: Surface,
    /// The directions of the point lights, and the reflection of each without and with shadows.
    points: Vec<(DVec3, [f64; 2])>,
    lobes: Lobes,
    /// The radiance without and with shadows, the lit fraction, and Schlick's weight.
    truth: [f64; 4],
    /// The units of the errors: two for the points, without and with shadows, then one for each entry of `truth`.
    unit: [f64; 6],
}

/// Random surfaces, with their lights and converged sums.
pub struct ProbeTraining(Vec<Item>);

/// Computes the converged sums under an environment of lobes.
fn converged(surface: &Surface, lobes: &Lobes, finest: f64) -> [f64; 4] {
    let Surface { wo, m, s } = *surface;
    let panels = visible_extents(wo, s).map(|e| (4.0 + 2.5 * finest.sqrt() * e).ceil() as usize);
    let cholesky = slope_cholesky(s);
    let o = direction_area(wo, m, cholesky);
    let mean = |panels, f: &dyn Fn(DVec3, DVec3, f64) -> DVec3| {
        visible_mean_panels(wo, m, s, panels, |slope| {
            let wn = normal_of_slope(slope);
            let wi = 2.0 * wn.dot(wo) * wn - wo;
            f(wn, wi, lit_fraction(Shadowing::Correlated, &o, &direction_area(wi, m, cholesky)))
        })
    };
    let light = mean(panels, &|_, wi, lit| {
        let radiance = lobes.radiance(wi);
        DVec3::new(radiance, radiance * lit, lit)
    });
    let fresnel = mean([14; 2], &|wn, _, _| DVec3::splat((1.0 - wo.dot(wn)).clamp(0.0, 1.0).powi(5)));
    [light.x, light.y, light.z, fresnel.x]
}

/// Returns random directions that a surface reflects.
fn reflected(r: &mut Random, surface: &Surface) -> Vec<DVec3> {
    let Surface { wo, m, s } = *surface;
    let cholesky = slope_cholesky(s);
    let mut out = Vec::with_capacity(POINTS);
    while out.len() < POINTS {
        let radius = (-2.0 * r.unit().max(1e-9).ln()).sqrt();
        let slope = slope_at(radius * DVec2::from_angle(r.range(0.0, TAU)), m, cholesky);
        // Slopes are drawn from the distribution and accepted in proportion to their visible area.
        if 3.0 * r.unit() < facet_area(wo, slope) {
            let wn = normal_of_slope(slope);
            out.push(2.0 * wn.dot(wo) * wn - wo);
        }
    }
    out
}

/// Returns surfaces with mean slope 0 and round, mostly wide lobes.
fn round_surfaces(n: usize, r: &mut Random) -> Vec<Surface> {
    (0..n)
        .map(|_| {
            let wo = spherical(r.unit().sqrt().asin().min(1.4), r.range(0.0, TAU));
            let large = r.log(0.3, 2.0);
            let (x, y) = (large * large, (large * r.log(0.6, 1.0)).powi(2));
            let axis = DVec2::from_angle(r.range(0.0, PI));
            let rotated = DVec3::new(axis.x * axis.x, axis.y * axis.y, axis.x * axis.y);
            Surface { wo, m: DVec2::ZERO, s: DVec3::new(y, y, 0.0) + (x - y) * rotated }
        })
        .collect()
}

impl ProbeTraining {
    /// Returns `n` surfaces like those of the tables but with another seed, and `2 * rough` rough surfaces, of which half
    /// have round lobes. Half of each group's surfaces are under smooth lobes, the others under sharp lobes.
    pub fn new(n: usize, rough: usize, seed: u64) -> Self {
        let mut r = Random(seed + 2);
        let mut all = surfaces(n, seed);
        all.extend(rough_surfaces(rough, seed + 1));
        all.extend(round_surfaces(rough, &mut r));
        let sharpness = |i: usize| if i.is_multiple_of(2) { Sharpness::Smooth } else { Sharpness::Sharp };
        let cases: Vec<(Surface, Vec<DVec3>, Lobes)> = all
            .iter()
            .enumerate()
            .map(|(i, s)| (*s, reflected(&mut r, s), Lobes::random(&mut r, sharpness(i))))
            .collect();
        let item = |(i, (surface, directions, lobes)): (usize, (Surface, Vec<DVec3>, Lobes))| {
            let points: Vec<_> = directions.into_iter().map(|d| (d, reflected_density(&surface, d))).collect();
            let rms = |k: usize| (points.iter().map(|p| p.1[k] * p.1[k]).sum::<f64>() / POINTS as f64).sqrt();
            let truth = converged(&surface, &lobes, sharpness(i).range().1);
            let [plain, lit, white, _] = truth;
            let unit = [rms(0), rms(1) + 0.3 * rms(0), plain.max(0.5), lit.max(0.3), white.max(0.3), 1.0];
            Item { surface, points, lobes, truth, unit }
        };
        Self(cases.into_par_iter().enumerate().map(item).collect())
    }

    /// Computes six kinds of errors per surface of a rule, in the units of the module. The first two kinds are RMS over the
    /// points, followed by the errors of each point.
    fn errors(&self, rule: ProbeRule<'_>) -> Vec<Vec<f64>> {
        self.0
            .par_iter()
            .map(|item| {
                let Surface { wo, m, s } = item.surface;
                let [plain, shadowed] =
                    [Shadowing::None, Shadowing::Correlated].map(|v| visible_probes(v, wo, m, s, rule.kernel));
                let o = direction_area(wo, plain.m, plain.cholesky);
                let mut points = [[0.0; 2]; POINTS];
                let mut sums = [0.0; 4];
                for node in rule.nodes(plain.wide) {
                    let p = visible_probe(&plain, wo, &node);
                    let of_lit = visible_probe(&shadowed, wo, &node);
                    let l = lit_probe(Shadowing::Correlated, &shadowed, &o, wo, 1.0, &of_lit, None);
                    let seen = l.narrowing * of_lit.variance;
                    let (plain, lit) = (p.weight, p.weight * l.lit);
                    for (sum, (d, _)) in points.iter_mut().zip(&item.points) {
                        sum[0] += plain * kernel(p.variance, p.wi.dot(*d));
                        sum[1] += lit * kernel(seen, l.wi.dot(*d));
                    }
                    sums[0] += plain * item.lobes.seen(p.wi, p.variance);
                    sums[1] += lit * item.lobes.seen(l.wi, seen);
                    sums[2] += lit;
                    sums[3] += plain * (1.0 - p.cosine).powi(5);
                }
                let per = (POINTS as f64).sqrt();
                let of_points = |k: usize| {
                    let error = move |(sum, (_, truth)): (&[f64; 2], &(DVec3, [f64; 2]))| {
                        (sum[k] - truth[k]) / (item.unit[k] * per)
                    };
                    points.iter().zip(&item.points).map(error)
                };
                let others = (0..4).map(|k| (sums[k] - item.truth[k]) / item.unit[k + 2]);
                of_points(0).chain(of_points(1)).chain(others).collect()
            })
            .collect()
    }

    /// Returns the RMS errors of a rule: for one point light and for lobes, each without and with shadows, then for the lit
    /// fraction and the Fresnel term.
    pub fn error(&self, rule: ProbeRule<'_>) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for errors in self.errors(rule) {
            for (i, e) in errors.iter().enumerate() {
                sums[kind(i)] += e * e;
            }
        }
        sums.map(|sum: f64| (sum / self.0.len() as f64).sqrt())
    }
}

fn kind(i: usize) -> usize {
    if i < 2 * POINTS { i / POINTS } else { i - 2 * POINTS + 2 }
}

/// A probe rule that owns its rings.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedRule {
    /// The kernels of the rule.
    pub kernel: ProbeKernel,
    /// The rings of the rule.
    pub rings: Vec<ProbeRing>,
}

impl FittedRule {
    /// Returns a [`ProbeRule`] that borrows the rings.
    pub fn rule(&self) -> ProbeRule<'_> {
        ProbeRule { kernel: self.kernel, rings: &self.rings }
    }

    /// Returns the unknowns, which are logarithms of ratios, for the wide rings and the kernels' fraction. The weight of the
    /// first ring and the radius of the last ring are the units. Unit variance sets the scale.
    fn unknowns(&self) -> Vec<f64> {
        let unit = self.rings[0].wide.weight;
        let last = self.rings.len() - 1;
        let of_ring = |(i, ring): (usize, &ProbeRing)| {
            let radius = (ring.count > 1 && i < last).then(|| (ring.wide.radius / self.rings[last].wide.radius).ln());
            let weight = (i > 0).then(|| (ring.wide.weight / unit).ln());
            [radius, weight, Some(ring.wide.cover.ln())].into_iter().flatten()
        };
        let share = self.kernel.share[1];
        self.rings.iter().enumerate().flat_map(of_ring).chain([(share / (1.0 - share)).ln()]).collect()
    }

    /// Builds a rule from these unknowns and the narrow rings of this rule.
    fn with_unknowns(&self, p: &[f64]) -> Self {
        let mut out = self.clone();
        let mut p = p.iter().map(|p| p.exp());
        let mut next = || p.next().unwrap_or(1.0);
        let last = out.rings.len() - 1;
        for (i, ring) in out.rings.iter_mut().enumerate() {
            ring.wide.radius = match ring.count {
                1 => 0.0,
                _ if i < last => next(),
                _ => 1.0,
            };
            ring.wide.weight = if i > 0 { next() } else { 1.0 };
            ring.wide.cover = next();
        }
        let sum: f64 = out.rings.iter().map(|r| r.count as f64 * r.wide.weight).sum();
        out.rings.iter_mut().for_each(|r| r.wide.weight /= sum);
        let variance: f64 =
            out.rings.iter().map(|r| 0.5 * r.count as f64 * r.wide.weight * r.wide.radius * r.wide.radius).sum();
        out.rings.iter_mut().for_each(|r| r.wide.radius /= variance.sqrt());
        let odds = next();
        out.kernel.share[1] = odds / (1.0 + odds);
        out
    }
}

/// Fits a rule to `training` by least squares. The search begins at `start` and takes at most `steps` steps. Large errors
/// get a lower weight.
pub fn fit_probes(training: &ProbeTraining, start: &FittedRule, steps: u32) -> FittedRule {
    let residuals = |p: &[f64]| -> Vec<f64> {
        let errors = training.errors(start.with_unknowns(p).rule());
        let weighted = errors.iter().flat_map(|e| e.iter().enumerate().map(|(i, e)| FACTORS[kind(i)] * e));
        weighted.map(|e| e / (1.0 + e * e).powf(0.25)).collect()
    };
    start.with_unknowns(&least_squares(start.unknowns(), steps, residuals))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::visible::specular::probe_rule;

    /// The truth for point lights must be a density.
    #[test]
    fn reflected_directions_add_up() {
        let surface = Surface { wo: spherical(0.7, 0.3), m: DVec2::new(0.1, 0.0), s: DVec3::new(0.05, 0.02, 0.01) };
        let mut sum = 0.0;
        let n = 200_000;
        for i in 0..n {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let azimuth = f64::from(i) * PI * (3.0 - 5f64.sqrt());
            sum += reflected_density(&surface, spherical(z.acos(), azimuth))[0];
        }
        let sum = sum * 4.0 * PI / f64::from(n);
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
    }

    #[test]
    fn packing_keeps_the_rule() {
        let rule = probe_rule(16);
        let fitted = FittedRule { kernel: rule.kernel, rings: rule.rings.to_vec() };
        let back = fitted.with_unknowns(&fitted.unknowns());
        let close = |a: f64, b: f64| (a - b).abs() < 1e-4;
        for (a, b) in fitted.rings.iter().zip(&back.rings) {
            let [a, b] = [a.wide, b.wide];
            assert!(close(a.radius, b.radius) && close(a.weight, b.weight) && close(a.cover, b.cover), "{a:?} {b:?}");
        }
        assert!(close(fitted.kernel.share[1], back.kernel.share[1]));
    }
}
