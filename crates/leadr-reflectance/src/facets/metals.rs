//! Named metals with complex indices of refraction, and an edge-tint approximation of their reflectance.
//!
//! The indices are tabulated spectra (Palik, *Handbook of Optical Constants of Solids*; Johnson and Christy 1972 for noble metals, and 1974
//! for chromium, iron and nickel). Red, green and blue are linear interpolations at 650, 550 and 450 nm. Renderers use two values: the reflectance at normal incidence, and the edge tint, which lowers
//! Schlick's curve before it rises ([`fresnel_edge_tint`](super::fresnel::fresnel_edge_tint)). `docs/measurements/materials.md` lists the
//! errors.

use super::fresnel::{edge_tint_weight, fresnel_conductor, fresnel_schlick};
use glam::DVec3;

/// A named metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// The name of the metal on the command line.
    pub name: &'static str,
    /// The real part of the refractive index for linear Rec.709 red, green and blue.
    pub eta: DVec3,
    /// The imaginary part of the refractive index (the extinction coefficient) for the same primaries.
    pub k: DVec3,
}

const fn metal(name: &'static str, eta: [f64; 3], k: [f64; 3]) -> Metal {
    Metal { name, eta: DVec3::from_array(eta), k: DVec3::from_array(k) }
}

/// All named metals.
pub const METALS: [Metal; 9] = [
    metal("aluminium", [1.3456, 0.96521, 0.61722], [7.4746, 6.3995, 5.3031]),
    metal("chromium", [3.1071, 3.1812, 2.3230], [3.3314, 3.3291, 3.1350]),
    metal("copper", [0.27105, 0.67693, 1.3164], [3.6092, 2.6248, 2.2921]),
    metal("gold", [0.18299, 0.42108, 1.3734], [3.4242, 2.3459, 1.7704]),
    metal("iron", [2.9114, 2.9497, 2.5845], [3.0893, 2.9318, 2.7670]),
    metal("nickel", [1.9900, 1.9212, 1.7290], [4.2086, 3.6158, 2.9435]),
    metal("platinum", [2.3757, 2.0847, 1.8453], [4.2655, 3.7153, 3.1365]),
    metal("silver", [0.15943, 0.14512, 0.13547], [3.9291, 3.1900, 2.3808]),
    metal("titanium", [2.7407, 2.5418, 2.2670], [3.8143, 3.4345, 3.0385]),
];

impl Metal {
    /// Returns the metal with this name, if any.
    pub fn named(name: &str) -> Option<&'static Self> {
        METALS.iter().find(|metal| metal.name == name)
    }

    /// Returns the linear RGB reflectance at a cosine of incidence by the Fresnel equations for conductors.
    pub fn reflectance(&self, cosine: f64) -> DVec3 {
        fresnel_conductor(cosine, self.eta, self.k)
    }

    /// Returns the reflectance at normal incidence.
    pub fn f0(&self) -> DVec3 {
        self.reflectance(1.0)
    }

    /// Returns the edge tint, clamped to 0..4. With this factor [`fresnel_edge_tint`](super::fresnel::fresnel_edge_tint) is exact at a
    /// cosine of 1/7, where the weight of the tint peaks.
    pub fn edge_tint(&self) -> DVec3 {
        let cosine = 1.0 / 7.0;
        let below = fresnel_schlick(self.f0(), cosine) - self.reflectance(cosine);
        (below / edge_tint_weight(cosine)).clamp(DVec3::ZERO, DVec3::splat(4.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::fresnel::fresnel_edge_tint;

    /// Compares the metals with the reflectances at normal incidence in artists' charts (Lagarde 2011 and later, from the same
    /// measurements, rounded).
    #[test]
    fn colours_are_those_of_the_charts() {
        for (name, chart) in [
            ("aluminium", [0.91, 0.92, 0.92]),
            ("copper", [0.95, 0.64, 0.54]),
            ("gold", [1.0, 0.77, 0.34]),
            ("iron", [0.56, 0.57, 0.58]),
            ("silver", [0.97, 0.96, 0.92]),
            ("titanium", [0.54, 0.50, 0.45]),
            ("platinum", [0.67, 0.64, 0.59]),
            ("nickel", [0.66, 0.61, 0.53]),
        ] {
            let f0 = Metal::named(name).unwrap().f0();
            assert!((f0 - DVec3::from_array(chart)).abs().max_element() < 0.1, "{name}: {f0}");
        }
        assert!(Metal::named("wood").is_none());
    }

    /// Returns two errors of the approximation `form`, a function of the cosine. The first is the largest error in any channel at any
    /// angle. The second is the error of the cosine-weighted mean over the hemisphere.
    fn error_of(metal: &Metal, form: impl Fn(f64) -> DVec3) -> (f64, f64) {
        let (mut most, mut mean) = (0.0f64, DVec3::ZERO);
        let steps = 4000;
        for i in 0..steps {
            let cosine = (f64::from(i) + 0.5) / f64::from(steps);
            let error = form(cosine) - metal.reflectance(cosine);
            most = most.max(error.abs().max_element());
            mean += error * (2.0 * cosine / f64::from(steps));
        }
        (most, mean.abs().max_element())
    }

    #[test]
    fn edge_tints_follow_the_indices() {
        for metal in METALS {
            let (f0, edge_tint) = (metal.f0(), metal.edge_tint());
            let (most, mean) = error_of(&metal, |cosine| fresnel_edge_tint(f0, edge_tint, cosine));
            let (schlick, schlick_mean) = error_of(&metal, |cosine| fresnel_schlick(f0, cosine));
            println!(
                "{:10} F0 {:.3} {:.3} {:.3}, tint {:.2} {:.2} {:.2}: max {most:.3}, mean {mean:.4}; Schlick {schlick:.3}, {schlick_mean:.4}",
                metal.name, f0.x, f0.y, f0.z, edge_tint.x, edge_tint.y, edge_tint.z
            );
            assert!(most < 0.025 && mean < 0.01, "{}: {most} {mean}", metal.name);
            assert!(most < 0.22 * schlick || schlick < 0.04, "{}: {most} {schlick}", metal.name);
        }
    }
}
