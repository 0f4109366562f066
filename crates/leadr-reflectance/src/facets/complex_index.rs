//! The exact Fresnel term of a material that is given by its reflectance at normal incidence and an F82 edge tint.
//!
//! A complex index `η + i k` has the reflectance `F0 = ((η − 1)² + k²) / ((η + 1)² + k²)` at normal incidence. All indices with the same `F0`
//! form a curve from `η = (1 − F0)/(1 + F0)` to `η = (1 + √F0)/(1 − √F0)`, where `k = 0` and the surface is a dielectric (Gulbrandsen 2014).
//! Along the curve, the reflectance at a cosine of 1/7 falls. [`complex_index`] therefore takes the dielectric for a reflectance that
//! dielectrics have, and for metals the point of the curve where the reflectance at 1/7 is that of
//! [`fresnel_edge_tint`](super::fresnel::fresnel_edge_tint). This is the angle at which a
//! [`Metal::edge_tint`](super::metals::Metal::edge_tint) is defined, so the index of a named metal comes back.
//!
//! For a large index, `√((η + i k)² − sin²θ) ≈ η + i k`. With `q = (1 + F0)/(1 − F0)` and `c = cos θ`, both polarisations then depend on
//! `y = sin²θ/(2 η)` alone:
//!
//! ```text
//! F ≈ 1 − c/(A − y) − c/(B + y),   A = q + c,   B = q c² + c
//! ```
//!
//! This is a quadratic equation for `y`. The exact reflectance of the solution corrects the argument of a second solution. The remaining
//! error of the reflectance is below 0.001 for `F0` above 0.45, and 0.01 at 0.2.

use super::fresnel::{edge_tint_weight, fresnel_conductor, fresnel_schlick, grazing_reflectance};
use crate::limits::at_least;
use glam::DVec3;

/// A complex index of refraction `η + i k` for each colour channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexIndex {
    /// The real part.
    pub eta: DVec3,
    /// The extinction coefficient.
    pub k: DVec3,
}

/// The reflectances at normal incidence for which an index is computed. The absorption of other surfaces is that of the nearest, scaled.
pub const INDEXED: [f64; 2] = [0.01, 0.99];

/// Dielectrics reflect at most the first value at normal incidence (diamond 0.17), and metals at least the second in one channel.
pub const METAL_REFLECTANCE: [f64; 2] = [0.2, 0.4];

/// Between these reflectances of a channel, a metal becomes a dielectric. No metal is as dark, and the index would depend on the last digits.
pub const DARK_CHANNEL: [f64; 2] = [0.05, 0.2];

/// The cosine at which the reflectance of a metal is matched, where the edge tint weighs most.
const EDGE: f64 = 1.0 / 7.0;

/// Returns the index of a surface with the reflectance `f0` at normal incidence, in linear RGB from 0 to 1. `edge_tint` is that of
/// [`fresnel_edge_tint`](super::fresnel::fresnel_edge_tint).
pub fn complex_index(f0: DVec3, edge_tint: DVec3) -> ComplexIndex {
    let within = |r: f64, [least, most]: [f64; 2]| ((r - least) / (most - least)).clamp(0.0, 1.0);
    let metallic = within(f0.max_element(), METAL_REFLECTANCE);
    let r = indexed_reflectance(f0);
    let channel = |r: f64, tint: f64| {
        let root = r.sqrt();
        let range = [(1.0 - r) / (1.0 + r), (1.0 + root) / (1.0 - root)];
        let edge = fresnel_schlick(DVec3::splat(r), EDGE).x - tint * edge_tint_weight(EDGE);
        let first = eta_of_edge(r, edge, range);
        let reached = fresnel_conductor(EDGE, DVec3::splat(first), DVec3::splat(extinction(r, first))).x;
        let metallic = metallic * within(r, DARK_CHANNEL);
        let eta = range[1] + metallic * (eta_of_edge(r, 2.0 * edge - reached, range) - range[1]);
        (eta, extinction(r, eta))
    };
    let [x, y, z] = [0, 1, 2].map(|i| channel(r[i], edge_tint[i]));
    ComplexIndex { eta: DVec3::new(x.0, y.0, z.0), k: DVec3::new(x.1, y.1, z.1) }
}

/// Returns the reflectance at normal incidence of the reflecting fraction of a surface, within [`INDEXED`].
fn indexed_reflectance(f0: DVec3) -> DVec3 {
    (f0 / grazing_reflectance(f0).max(DVec3::splat(1e-6))).clamp(DVec3::splat(INDEXED[0]), DVec3::splat(INDEXED[1]))
}

/// Returns the `η` within `range` for which the approximation has the reflectance `edge` at the cosine [`EDGE`].
fn eta_of_edge(r: f64, edge: f64, range: [f64; 2]) -> f64 {
    let (c, q) = (EDGE, (1.0 + r) / (1.0 - r));
    let (a, b) = (q + c, q * c * c + c);
    let d = c * (a + b) / at_least(1.0 - edge, 1e-4);
    let root = at_least((a + b) * (a + b) - 4.0 * d, 0.0).sqrt();
    // The smaller of the roots, without cancellation.
    let y = 2.0 * (d - a * b) / (a - b + root);
    (0.5 * (1.0 - c * c) / at_least(y, 1e-6)).clamp(range[0], range[1])
}

/// Returns the `k` that gives the reflectance `r` at normal incidence together with `eta`.
fn extinction(r: f64, eta: f64) -> f64 {
    at_least((r * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - r), 0.0).sqrt()
}

/// Returns the exact reflectance of a surface with the reflectance `f0` at normal incidence and its [`complex_index`]. Below 2 %, only a
/// fraction of the surface reflects ([`grazing_reflectance`]).
pub fn fresnel_exact(f0: DVec3, index: &ComplexIndex, cosine: f64) -> DVec3 {
    let grazing = grazing_reflectance(f0);
    let absorbed = DVec3::ONE - fresnel_conductor(cosine.clamp(0.0, 1.0), index.eta, index.k);
    grazing - absorbed * (grazing - f0) / (DVec3::ONE - indexed_reflectance(f0))
}

/// Returns the exact reflectance minus Schlick's. It vanishes at normal and at grazing incidence.
pub fn fresnel_deviation(f0: DVec3, index: &ComplexIndex, cosine: f64) -> DVec3 {
    fresnel_exact(f0, index, cosine) - fresnel_schlick(f0, cosine)
}

/// The cosines and the weights of a Gauss-Legendre rule for means over the cosine-weighted hemisphere.
const HEMISPHERE: [[f64; 2]; 4] =
    [[0.0694318, 0.0241522], [0.3300095, 0.2152141], [0.6699905, 0.4369311], [0.9305682, 0.3237026]];

/// Returns the mean of [`fresnel_deviation`] over the cosine-weighted hemisphere, with an error of at most 0.001.
pub fn average_deviation(f0: DVec3, index: &ComplexIndex) -> DVec3 {
    HEMISPHERE.iter().map(|[cosine, weight]| *weight * fresnel_deviation(f0, index, *cosine)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::fresnel::{fresnel_dielectric, fresnel_edge_tint};
    use crate::facets::metals::METALS;

    const COSINES: u32 = 1000;

    fn cosines() -> impl Iterator<Item = f64> {
        (0..=COSINES).map(|i| f64::from(i) / f64::from(COSINES))
    }

    /// The largest error of a form in any channel at any angle.
    fn worst(form: impl Fn(f64) -> DVec3, truth: impl Fn(f64) -> DVec3) -> f64 {
        cosines().map(|c| (form(c) - truth(c)).abs().max_element()).fold(0.0, f64::max)
    }

    #[test]
    fn dielectrics_are_exact() {
        for eta in [1.33, 1.5, 2.0, 2.4] {
            let f0 = DVec3::splat(((eta - 1.0) / (eta + 1.0f64)).powi(2));
            let index = complex_index(f0, DVec3::ZERO);
            let error = worst(|c| fresnel_exact(f0, &index, c), |c| DVec3::splat(fresnel_dielectric(c, eta)));
            let schlick = worst(|c| fresnel_schlick(f0, c), |c| DVec3::splat(fresnel_dielectric(c, eta)));
            println!("index {eta}: exact {error:.1e}, Schlick {schlick:.3}");
            assert!(error < 1e-7 && schlick > 0.02);
        }
        // A hundredth of the surface of an index of 1.33 reflects.
        let f0 = DVec3::splat(0.0002);
        let index = complex_index(f0, DVec3::ZERO);
        assert!((fresnel_exact(f0, &index, 1.0) - f0).abs().max_element() < 1e-12);
        assert!((fresnel_exact(f0, &index, 0.0) - 0.01).abs().max_element() < 1e-12);
    }

    /// The command prints the table of docs/measurements/materials.md.
    #[test]
    fn metals_come_back() {
        for metal in METALS {
            let (f0, tint) = (metal.f0(), metal.edge_tint());
            let truth = |c| metal.reflectance(c);
            let index = complex_index(f0, tint);
            let exact = worst(|c| fresnel_exact(f0, &index, c), truth);
            let tinted = worst(|c| fresnel_edge_tint(f0, tint, c), truth);
            let schlick = worst(|c| fresnel_schlick(f0, c), truth);
            println!("{:10} exact {exact:.4}, F82 tint {tinted:.4}, Schlick {schlick:.4}", metal.name);
            assert!(exact < 0.003 && exact < 0.4 * tinted, "{}: {exact} {tinted}", metal.name);
        }
    }

    /// A white furnace returns all light: no absorption at a reflectance of 1.
    #[test]
    fn ends_are_those_of_schlick() {
        for f0 in [DVec3::ZERO, DVec3::ONE, DVec3::new(0.02, 0.3, 0.995), DVec3::new(0.005, 0.01, 0.0)] {
            for tint in [DVec3::ZERO, DVec3::splat(4.0)] {
                let index = complex_index(f0, tint);
                assert!((fresnel_exact(f0, &index, 1.0) - f0).abs().max_element() < 1e-7, "{f0}");
                assert!((fresnel_exact(f0, &index, 0.0) - grazing_reflectance(f0)).abs().max_element() < 1e-7);
                for c in cosines() {
                    let f = fresnel_exact(f0, &index, c);
                    assert!(f.min_element() >= 0.0 && f.max_element() <= 1.0, "{f0} {c}: {f}");
                }
            }
        }
        let white = complex_index(DVec3::ONE, DVec3::ZERO);
        assert!(cosines().all(|c| (fresnel_exact(DVec3::ONE, &white, c) - 1.0).abs().max_element() < 1e-12));
    }

    #[test]
    fn the_mean_over_the_hemisphere() {
        for (f0, tint) in [(0.04, 0.0), (0.17, 0.0), (0.55, 3.4), (0.91, 2.0), (0.95, 0.2), (1.0, 0.0)] {
            let (f0, tint) = (DVec3::splat(f0), DVec3::splat(tint));
            let index = complex_index(f0, tint);
            let steps = 20_000;
            let mean = (0..steps)
                .map(|i| fresnel_deviation(f0, &index, ((f64::from(i) + 0.5) / f64::from(steps)).sqrt()))
                .sum::<DVec3>()
                / f64::from(steps);
            let error = (average_deviation(f0, &index) - mean).abs().max_element();
            assert!(error < 1e-3, "{f0}: {error}");
        }
    }
}
