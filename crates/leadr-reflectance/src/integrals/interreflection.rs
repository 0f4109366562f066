//! Light that the facets of a relief send to each other, for classes of facets of any albedo, in closed form.
//!
//! Let `H_k` be the blocked part of the hemisphere of the facets of class `k` ([`ClassSky::blocked`]), and `g_k = N_k H_k` its product with
//! the facet area. In blocked directions, the facets see the relief. The form assumes that all blocked directions see the same mean
//! radiosity `B`, which is weighted by `g` because of reciprocity. With the irradiance `E_k` from outside,
//!
//! ```text
//! B_k = ρ_k (E_k + H_k B),   B = Σ g_k B_k / Σ g_k   ⇒   B = Σ g_k ρ_k E_k / Σ g_k (1 − ρ_k H_k)
//! ```
//!
//! A light that sends the irradiance `E` through the mesosurface, with the flux shares `s_k` of the classes, has `N_k E_k = E s_k`. The flux
//! shares of a light are the visible shares of its direction, and those of the sky are [`ClassSky::flux`].
//!
//! * *Furnace.* A white relief under a white sky has `B = E`, so each facet reflects what a flat surface reflects.
//! * *Energy.* A white relief returns all light: `Σ N_k B_k (1 − H_k) = E`.
//! * *Accuracy.* Under a sky, the total is within 1 % of paths over studs, bricks, tiles, scans and noise, and under a sun within 2 % of the
//!   mean over viewers (`lab` test `light_between_bumps_follows_paths`). The form does not depend on the azimuths of viewer and light.
//!   Opposite the light, deep grooves see walls that are lit, and the form is too dark.

use glam::DVec3;

use crate::masking::class_sky::ClassSky;
use crate::masking::classes::MOST_CLASSES;

/// Facets that block less than this of each other see no radiosity, which would be a quotient of rounding errors.
const FLAT: f64 = 1e-5;

/// The response of a relief to light from outside, once per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReliefBounces {
    /// `H_k ρ_k / Σ g (1 − ρ H)`, the mean radiosity in blocked directions per unit of flux that the class receives.
    pub weights: [DVec3; MOST_CLASSES],
}

impl ReliefBounces {
    /// Computes the response of classes of the given `albedo`, from 0 to 1. The albedo is the whole reflectance of the facets for diffuse
    /// light: for a metal, the mean of its Fresnel reflectance.
    pub fn new(sky: &ClassSky, albedo: &[DVec3; MOST_CLASSES]) -> Self {
        let blocked = sky.blocked();
        let mut under = DVec3::ZERO;
        for k in 0..MOST_CLASSES {
            under += sky.areas[k] * blocked[k] * (1.0 - albedo[k] * blocked[k]);
        }
        let per = under / (under * under + FLAT * FLAT);
        Self { weights: std::array::from_fn(|k| blocked[k] * albedo[k] * per) }
    }

    /// Returns the radiosity `B` that the facets see in blocked directions. `irradiance` is that of the mesosurface, without shadows, and
    /// `shares` are the flux shares of the classes.
    pub fn radiosity(&self, irradiance: DVec3, shares: &[f64; MOST_CLASSES]) -> DVec3 {
        irradiance * self.weights.iter().zip(shares).map(|(&weight, &share)| weight * share).sum::<DVec3>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::masking::classes::Class;
    use crate::random::Random;
    use glam::DVec2;

    fn relief(count: usize, random: &mut Random) -> ClassSky {
        let classes: Vec<Class> = (0..count)
            .map(|_| {
                let (x, y) = (random.log(0.01, 2.0), random.log(0.01, 2.0));
                Class {
                    share: random.range(0.1, 1.0),
                    mean: DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0)),
                    covariance: DVec3::new(x * x, y * y, 0.3 * x * y),
                    height: random.range(-1.0, 1.0),
                    height_variance: random.log(1e-3, 1.0),
                }
            })
            .collect();
        ClassSky::new(&classes, std::array::from_fn(|_| random.log(0.01, 1.0)))
    }

    #[test]
    fn white_reliefs_return_all_light() {
        let mut random = Random(5);
        for i in 0..400 {
            let sky = relief(1 + i % 4, &mut random);
            let bounces = ReliefBounces::new(&sky, &[DVec3::ONE; MOST_CLASSES]);
            let (b, blocked) = (bounces.radiosity(DVec3::ONE, &sky.flux), sky.blocked());
            assert!(blocked.iter().all(|blocked| (blocked * (b - 1.0)).abs().max_element() < 1e-3), "{b}");
            // A sun lights only one class.
            let lit: [f64; MOST_CLASSES] = std::array::from_fn(|k| f64::from(k == i / 4 % (1 + i % 4)));
            let b = bounces.radiosity(DVec3::ONE, &lit).x;
            let returned: f64 =
                (0..MOST_CLASSES).map(|k| (1.0 - blocked[k]) * (lit[k] + sky.areas[k] * blocked[k] * b)).sum();
            assert!((returned - 1.0).abs() < 5e-4, "{returned}");
        }
    }

    #[test]
    fn one_class_is_a_geometric_series() {
        let sky = relief(1, &mut Random(2));
        let (rho, h) = (DVec3::new(0.9, 0.5, 0.0), sky.blocked()[0]);
        let b = ReliefBounces::new(&sky, &[rho; MOST_CLASSES]).radiosity(DVec3::ONE, &[1.0, 0.0, 0.0, 0.0]);
        let series = rho * (1.0 - h) / (1.0 - rho * h);
        assert!((b - series).abs().max_element() < 2e-3, "{b} {series}");
    }

    #[test]
    fn flat_surfaces_see_no_other_facets() {
        let (areas, flux) = ([1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
        let sky = ClassSky { mean: DVec2::ZERO, areas, flux, depths: [0.0; MOST_CLASSES] };
        assert_eq!(ReliefBounces::new(&sky, &[DVec3::ONE; MOST_CLASSES]).weights, [DVec3::ZERO; MOST_CLASSES]);
    }
}
