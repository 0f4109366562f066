//! Computes the nodes of an [`EnergyTable`](leadr_reflectance::materials::energy::EnergyTable) by quadrature. The nodes are
//! stored in `materials/energy.bin`.

use glam::DVec3;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::integrals::directional_albedo::{AlbedoRule, directional_albedo};
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::energy::{ENERGY_ALPHAS, ENERGY_COSINES, SplitAlbedo, energy_weight};
use rayon::prelude::*;

/// The number of samples per cell and axis at which the table is compared with the integral.
const STEPS: usize = 6;

/// Computes the nodes `(1 − ideal, grazing)` in units of 1/65535, ordered by cosine, then by roughness. The nodes are raised
/// until the table is never below the albedo.
pub fn energy_nodes<D: SlopeDistribution>(distribution: impl Fn(f64) -> D + Sync) -> Vec<[u16; 2]> {
    let (nx, ny) = ((ENERGY_COSINES - 1) * STEPS + 1, (ENERGY_ALPHAS - 1) * STEPS + 1);
    let rule = AlbedoRule { azimuths: 5, slopes: 5, order: 7 };
    let exact: Vec<[f64; 2]> = (0..nx * ny)
        .into_par_iter()
        .map(|i| {
            let at = |k: usize, n: usize, power| (k as f64 / (n - 1) as f64).powi(power);
            let albedo = albedo_at(&distribution, at(i / nx, ny, 4), at(i % nx, nx, 2), rule);
            [albedo.ideal, albedo.grazing]
        })
        .collect();
    let fine = |x: usize, y: usize| exact[x + nx * y];
    let mut nodes: Vec<[f64; 2]> =
        (0..COUNT).map(|i| fine(i % ENERGY_COSINES * STEPS, i / ENERGY_COSINES * STEPS)).collect();
    // By Kaczmarz's method, all nodes around a deficit share the correction.
    for _ in 0..100 {
        let mut missing = 0.0f64;
        for (x, y) in (0..ENERGY_ALPHAS - 1).flat_map(|y| (0..ENERGY_COSINES - 1).map(move |x| (x, y))) {
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(cx, cy)| x + cx + ENERGY_COSINES * (y + cy));
            for (sx, sy, k) in
                (0..=STEPS).flat_map(|sx| (0..=STEPS).flat_map(move |sy| (0..2).map(move |k| (sx, sy, k))))
            {
                let (tx, ty) = (energy_weight(x, sx as f64 / STEPS as f64), sy as f64 / STEPS as f64);
                let weights = [(1.0 - tx) * (1.0 - ty), tx * (1.0 - ty), (1.0 - tx) * ty, tx * ty];
                let linear: f64 = corners.iter().zip(weights).map(|(c, w)| nodes[*c][k] * w).sum();
                // An albedo cannot exceed 1.
                let short = (fine(x * STEPS + sx, y * STEPS + sy)[k] + MARGIN).min(1.0) - linear;
                let free = |c: usize| if nodes[c][k] < 1.0 { 1.0 } else { 0.0 };
                let squares: f64 = corners.iter().zip(weights).map(|(c, w)| free(*c) * w * w).sum();
                // Without this test, the neighbours of a clamped node would grow without bound.
                if short <= 0.0 || squares < 0.05 {
                    continue;
                }
                missing = missing.max(short);
                for (c, w) in corners.into_iter().zip(weights) {
                    nodes[c][k] = (nodes[c][k] + short * w / squares).min(1.0);
                }
            }
        }
        if missing < 1e-7 {
            break;
        }
    }
    let counts = |[ideal, grazing]: [f64; 2]| {
        [((1.0 - ideal) * 65535.0).floor() as u16, (grazing.min(1.0) * 65535.0).ceil() as u16]
    };
    nodes.into_iter().map(counts).collect()
}

const COUNT: usize = ENERGY_COSINES * ENERGY_ALPHAS;

/// The smallest margin of the table above the albedo, which covers points between the samples.
const MARGIN: f64 = 5e-5;

/// The smallest cosine that is integrated.
const NEAR: f64 = 2e-4;

/// Computes the albedo, including its limits for smooth surfaces and for viewers at grazing angles.
fn albedo_at<D: SlopeDistribution>(
    distribution: &(impl Fn(f64) -> D + Sync),
    alpha: f64,
    cosine: f64,
    rule: AlbedoRule,
) -> SplitAlbedo {
    if alpha < 1e-4 {
        return SplitAlbedo { ideal: 1.0, grazing: (1.0 - cosine).powi(5) };
    }
    let facets = distribution(alpha);
    let at = |c: f64| {
        let wo = DVec3::new(((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c);
        directional_albedo(&facets, Masking::SmithCorrelated, wo, None, rule)
    };
    if cosine >= NEAR {
        return at(cosine);
    }
    // Near grazing incidence the albedo is linear in the cosine, and at grazing incidence nothing is lost.
    let (near, next, t) = (at(NEAR), at(2.0 * NEAR), cosine / NEAR);
    SplitAlbedo {
        ideal: 1.0 - t * (1.0 - near.ideal),
        grazing: near.grazing + (1.0 - t) * (near.grazing - next.grazing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use leadr_reflectance::facets::beckmann::Beckmann;
    use leadr_reflectance::facets::ggx::Ggx;
    use leadr_reflectance::materials::energy::{EnergyTable, compensation_color, entered};
    use leadr_reflectance::materials::multiscattering::{BOUNCES, BOUNCES_LOSSY, multiscattering_albedo};
    use std::sync::LazyLock;

    const RULE: AlbedoRule = AlbedoRule { azimuths: 5, slopes: 5, order: 7 };

    /// The roughness, cosine, exact albedo and tabulated albedo of each point.
    type Compared = Vec<(f64, f64, SplitAlbedo, SplitAlbedo)>;

    /// Points between nodes for GGX and Beckmann, with roughness α from .03 to 1 and cosines from 0 to 1. The largest errors
    /// lie in narrow regions of smooth surfaces at grazing views. A few hundred random points would miss the narrow regions.
    static COMPARED: LazyLock<[Compared; 2]> = LazyLock::new(|| [false, true].map(compared));

    fn compared(beckmann: bool) -> Compared {
        let table = if beckmann { EnergyTable::beckmann() } else { EnergyTable::ggx() };
        let (alphas, cosines) = (45, 97);
        let entry = |i: usize| {
            let alpha = 0.03f64.powf(1.0 - (i / cosines) as f64 / (alphas - 1) as f64);
            let c = ((i % cosines) as f64 / (cosines - 1) as f64).powi(2);
            let exact = if beckmann {
                albedo_at(&|a| Beckmann::isotropic(DVec2::ZERO, a), alpha, c, RULE)
            } else {
                albedo_at(&|a| Ggx::isotropic(DVec2::ZERO, a), alpha, c, RULE)
            };
            (alpha, c, exact, table.albedo(alpha, c))
        };
        (0..alphas * cosines).into_par_iter().map(entry).collect()
    }

    #[test]
    fn table_never_underestimates_and_is_close() {
        for beckmann in [false, true] {
            let (mut low, mut high) = ([0.0f64; 2], [0.0f64; 2]);
            for (_, _, exact, got) in &COMPARED[usize::from(beckmann)] {
                let over = [got.ideal - exact.ideal, got.grazing - exact.grazing];
                for k in 0..2 {
                    (low[k], high[k]) = (low[k].min(over[k]), high[k].max(over[k]));
                }
            }
            println!("Beckmann {beckmann}: table less integral, ideal and grazing: {low:.5?} to {high:.5?}");
            assert!(low.iter().all(|l| *l > -2e-5) && high.iter().all(|h| *h < 4e-3), "{low:?} {high:?}");
        }
    }

    /// Tests the specular term, its further bounces and the diffuse base in a white furnace. No surface may be brighter than
    /// the furnace, and a white surface must be as bright as the furnace.
    #[test]
    fn white_furnace() {
        for beckmann in [false, true] {
            let table = if beckmann { EnergyTable::beckmann() } else { EnergyTable::ggx() };
            let (mut darkest, mut brightest) = ((1.0f64, 0.0, 0.0), 0.0f64);
            for &(alpha, c, exact, got) in &COMPARED[usize::from(beckmann)] {
                let average = table.average(alpha).ideal;
                for f0 in [0.0, 0.01, 0.02, 0.04, 0.08, 0.2, 0.5, 0.9, 1.0].map(DVec3::splat) {
                    let specular = exact.of(f0) + (1.0 - got.ideal) * compensation_color(f0, average);
                    for rho in [0.0, 0.2, 0.5, 0.8, 1.0] {
                        for fit in [BOUNCES, BOUNCES_LOSSY] {
                            let entering = entered(f0, got, average);
                            let diffuse = multiscattering_albedo(fit.at(alpha), DVec3::splat(rho), entering);
                            let total = (specular + diffuse).x;
                            brightest = brightest.max(total);
                            if rho == 1.0 && fit == BOUNCES && total < darkest.0 {
                                darkest = (total, alpha, c);
                            }
                        }
                    }
                }
            }
            let (least, alpha, c) = darkest;
            println!(
                "Beckmann {beckmann}: white surfaces {least:.5} (α {alpha:.3}, cos {c:.3}) and more, none above {brightest:.7}"
            );
            assert!(least > 0.995 && brightest < 1.0 + 2e-5, "{darkest:?} {brightest}");
        }
    }
}
