//! The directional albedo of specular microfacets, the energy that a single bounce loses, and two methods that compensate for the loss
//! (Kulla and Conty 2017; Turquin 2019).
//!
//! A microfacet BRDF models one bounce. Ideal specular facets reflect the fraction `E(c, α) < 1` towards a viewer of cosine `c`. The
//! remaining light hits other facets and leaves the surface later. The [`compensation_lobe`] adds this light as
//! `(1 − E_o)(1 − E_i) / (π (1 − E_avg))`. The lobe is reciprocal, and its albedo is exactly `1 − E_o`. Each further bounce tints the light
//! by the mean Fresnel reflectance.
//!
//! The table stores [`directional_albedo`](crate::integrals::directional_albedo). Between nodes, the table is never below the true albedo,
//! so no result exceeds 1. The average row is the exact mean of the interpolated table.

use crate::facets::fresnel::grazing_reflectance;
use crate::limits::{at_least, unit};
use glam::DVec3;
use std::f64::consts::PI;

/// The directional albedo under Schlick's Fresnel term, split into two parts, because the term is linear in F0 (Karis 2013).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplitAlbedo {
    /// The albedo for `F = 1`.
    pub ideal: f64,
    /// The albedo for `F = (1 − cos θ_d)⁵`.
    pub grazing: f64,
}

impl SplitAlbedo {
    /// Returns the factor that multiplies `F0` in the albedo.
    pub fn scale(&self) -> f64 {
        self.ideal - self.grazing
    }

    /// Returns the additive part of the albedo, per unit of reflectance at grazing incidence.
    pub fn bias(&self) -> f64 {
        self.grazing
    }

    /// Returns the albedo for [`fresnel_schlick`](crate::facets::fresnel::fresnel_schlick) with this `f0`.
    pub fn of(&self, f0: DVec3) -> DVec3 {
        f0 * self.scale() + grazing_reflectance(f0) * self.grazing
    }
}

/// The number of nodes of an [`EnergyTable`] over `√cos`, from 0 to 1.
pub const ENERGY_COSINES: usize = 32;
/// The number of nodes of an [`EnergyTable`] over the fourth root of `α`, from 0 to 1.
pub const ENERGY_ALPHAS: usize = 48;
/// The number of texels in a row, with one texel per cosine and one texel for the average.
pub const ENERGY_ROW: usize = ENERGY_COSINES + 1;

/// The table nodes for GGX facets, then for Beckmann facets, as 16-bit little-endian unorms. Each node holds `1 − ideal` and `grazing`, and
/// the cosine varies fastest. Example 20 writes the file.
static NODES: &[u8; 2 * 4 * ENERGY_COSINES * ENERGY_ALPHAS] = include_bytes!("energy.bin");

/// A table of the specular albedo by roughness and viewer angle. Texel `(x, y)` is `(1 − ideal, grazing)` at `cos = (x/31)²`,
/// `α = (y/47)⁴`. The column `x = 32` holds the average over the hemisphere. Interpolation is linear in `√cos` ([`energy_weight`]) and in
/// the fourth root of `α`. The loss of smooth facets depends on `cos / α`, so rows are denser at small `α`.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyTable(Vec<[f32; 2]>);

impl EnergyTable {
    /// The number of texels in a table.
    pub const TEXELS: usize = ENERGY_ROW * ENERGY_ALPHAS;

    /// Returns the table of GGX facets with height-correlated masking.
    pub fn ggx() -> Self {
        Self::stored(0)
    }

    /// Returns the table of Beckmann facets with height-correlated masking.
    pub fn beckmann() -> Self {
        Self::stored(1)
    }

    fn stored(table: usize) -> Self {
        let (words, _) = NODES.as_chunks::<2>();
        let at = |i: usize| f32::from(u16::from_le_bytes(words[i])) / 65535.0;
        // Each node `x + 32 y` holds `(1 − ideal, grazing)`.
        let node = |i: usize| [0, 1].map(|k| at(2 * (table * ENERGY_COSINES * ENERGY_ALPHAS + i) + k));
        let rows = (0..ENERGY_ALPHAS).flat_map(|y| {
            let row: Vec<[f32; 2]> = (0..ENERGY_COSINES).map(|x| node(x + ENERGY_COSINES * y)).collect();
            let average = [0, 1].map(|k| row_average(&row, k) as f32);
            row.into_iter().chain([average])
        });
        Self(rows.collect())
    }

    /// Returns the texels, row by row, in the layout of `leadr/materials/energy.glsl`.
    pub fn texels(&self) -> &[[f32; 2]] {
        &self.0
    }

    /// Returns the albedo towards a viewer. The arguments are clamped to 0..1.
    pub fn albedo(&self, alpha: f64, cosine: f64) -> SplitAlbedo {
        let x = unit(cosine).sqrt() * (ENERGY_COSINES - 1) as f64;
        let at = (x as usize).min(ENERGY_COSINES - 2);
        let t = energy_weight(at, x - at as f64);
        let mix = |y: usize, k: usize| {
            let [a, b] = [0, 1].map(|i| f64::from(self.0[y * ENERGY_ROW + at + i][k]));
            a + (b - a) * t
        };
        self.between_rows(alpha, mix)
    }

    /// Returns the mean albedo over the cosine-weighted hemisphere.
    pub fn average(&self, alpha: f64) -> SplitAlbedo {
        self.between_rows(alpha, |y, k| f64::from(self.0[y * ENERGY_ROW + ENERGY_COSINES][k]))
    }

    fn between_rows(&self, alpha: f64, row: impl Fn(usize, usize) -> f64) -> SplitAlbedo {
        let y = unit(alpha).sqrt().sqrt() * (ENERGY_ALPHAS - 1) as f64;
        let at = (y as usize).min(ENERGY_ALPHAS - 2);
        let t = y - at as f64;
        let [loss, grazing] = [0, 1].map(|k| row(at, k) + (row(at + 1, k) - row(at, k)) * t);
        SplitAlbedo { ideal: 1.0 - loss, grazing }
    }
}

/// Returns the interpolation weight of the next node, at the fraction `t` of the interval after node `column` in `√cos`. Near grazing
/// incidence, albedos are linear in the cosine.
pub fn energy_weight(column: usize, t: f64) -> f64 {
    if column == 0 { t * t } else { t }
}

/// Computes `2 ∫ f(c) c dc` of a row as `4 ∫ f u³ du`, with `u = √c`.
fn row_average(row: &[[f32; 2]], k: usize) -> f64 {
    let n = (row.len() - 1) as f64;
    let piece = |i: usize| {
        let (a, b) = (i as f64 / n, (i + 1) as f64 / n);
        let (fa, fb) = (f64::from(row[i][k]), f64::from(row[i + 1][k]));
        if i == 0 {
            return (fa + (fb - fa) * 2.0 / 3.0) * b.powi(4);
        }
        let slope = (fb - fa) * n;
        (fa - slope * a) * (b.powi(4) - a.powi(4)) + slope * 0.8 * (b.powi(5) - a.powi(5))
    };
    (0..row.len() - 1).map(piece).sum()
}

/// Returns the mean of Schlick's Fresnel term over the cosine-weighted hemisphere, `F0 + (F90 − F0) / 21`.
pub fn average_fresnel(f0: DVec3) -> DVec3 {
    f0 + (grazing_reflectance(f0) - f0) / 21.0
}

/// Returns the fraction of the lost energy that leaves after all further bounces, `F² E / (1 − F (1 − E))`. `F` is [`average_fresnel`], and
/// `E` is the average albedo of ideal specular facets. The result is 1 for `F0 = 1`.
pub fn compensation_color(f0: DVec3, average_ideal: f64) -> DVec3 {
    bounced_color(average_fresnel(f0), average_ideal)
}

/// Returns [`compensation_color`] for the mean `f` of any Fresnel term over the cosine-weighted hemisphere.
pub fn bounced_color(f: DVec3, average_ideal: f64) -> DVec3 {
    f * f * average_ideal / (DVec3::ONE - f * (1.0 - average_ideal)).max(DVec3::splat(1e-6))
}

/// Returns the multiple-scattering BRDF of ideal specular facets, `(1 − E_o)(1 − E_i) / (π (1 − E_avg))`, per steradian. Multiply the lobe
/// by [`compensation_color`]. The lobe is reciprocal, and its albedo towards the viewer is `1 − E_o`.
pub fn compensation_lobe(ideal_o: f64, ideal_i: f64, average_ideal: f64) -> f64 {
    (1.0 - ideal_o) * (1.0 - ideal_i) / (PI * at_least(1.0 - average_ideal, 1e-6))
}

/// Returns `1 + F0 (1/E_o − 1)`, the factor of the single-scattering lobe that gives the multiple-scattering albedo for `F0 = 1` (Turquin
/// 2019). No second lobe is needed, but the result is not reciprocal, and all light stays in the first lobe.
pub fn compensation_scale(f0: DVec3, ideal_o: f64) -> DVec3 {
    let e = at_least(ideal_o, 1e-3);
    DVec3::ONE + f0 * ((1.0 - e) / e)
}

/// Returns the total specular albedo towards the viewer, which is [`SplitAlbedo::of`] plus the compensation.
pub fn specular_albedo(f0: DVec3, albedo: SplitAlbedo, average_ideal: f64) -> DVec3 {
    albedo.of(f0) + (1.0 - albedo.ideal) * compensation_color(f0, average_ideal)
}

/// Returns the energy that is left for the substrate, `1 − ` [`specular_albedo`], at least 0. The energy is linear in the table, so
/// [`EnergyTable::average`] gives the mean over the hemisphere.
pub fn entered(f0: DVec3, albedo: SplitAlbedo, average_ideal: f64) -> DVec3 {
    (DVec3::ONE - specular_albedo(f0, albedo, average_ideal)).max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::composite_gauss;

    fn mean(f: impl Fn(f64) -> f64) -> f64 {
        composite_gauss(0.0, 1.0, 31, 6).into_iter().map(|(u, w)| w * 4.0 * u.powi(3) * f(u * u)).sum()
    }

    #[test]
    fn averages_are_of_the_table_itself() {
        for table in [EnergyTable::ggx(), EnergyTable::beckmann()] {
            for alpha in [0.0, 0.03, 0.2, 0.77, 1.0] {
                let average = table.average(alpha);
                assert!((mean(|c| table.albedo(alpha, c).ideal) - average.ideal).abs() < 1e-6);
                assert!((mean(|c| table.albedo(alpha, c).grazing) - average.grazing).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn compensation_lobe_returns_lost_energy() {
        let table = EnergyTable::ggx();
        for alpha in [0.1, 0.5, 1.0] {
            let average = table.average(alpha).ideal;
            for c in [0.01, 0.4, 1.0] {
                let o = table.albedo(alpha, c).ideal;
                let got = PI * mean(|i| compensation_lobe(o, table.albedo(alpha, i).ideal, average));
                assert!((got - (1.0 - o)).abs() < 1e-6, "{alpha} {c}: {got}");
                assert!((compensation_scale(DVec3::ONE, o).x * o - 1.0).abs() < 1e-12);
            }
            assert!((compensation_color(DVec3::ONE, average).x - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_mean_of_schlicks_term() {
        let f0 = DVec3::new(0.04, 0.3, 1.0);
        let want: DVec3 = composite_gauss(0.0, 1.0, 1, 8)
            .into_iter()
            .map(|(c, w)| 2.0 * w * c * crate::facets::fresnel::fresnel_schlick(f0, c))
            .sum();
        assert!((average_fresnel(f0) - want).length() < 1e-14);
    }

    #[test]
    fn finite_for_anything() {
        let table = EnergyTable::beckmann();
        for x in [f64::NAN, -1.0, 0.0, 1e-300, 1.0, 1e300] {
            let (a, average) = (table.albedo(x, x), table.average(x));
            assert!((0.0..=1.0).contains(&a.ideal) && (0.0..=1.0).contains(&a.grazing));
            for f0 in [0.0, 0.5, 1.0] {
                let f0 = DVec3::splat(f0);
                assert!((0.0..=1.0).contains(&entered(f0, a, average.ideal).x));
                assert!(compensation_scale(f0, a.ideal).is_finite());
                assert!(compensation_lobe(a.ideal, a.ideal, average.ideal).is_finite());
            }
        }
    }
}
