//! A synthetic material for measurement and fitting, and the use of fits as materials of displaced surfaces.

use glam::{DVec2, DVec3};

use leadr_maps::HeightMap;
use leadr_maps::material::{Input, Material, Relief};
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::extraction::fit::{Fit, FitOptions, fit};
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::lambert::Lambert;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_scenes::fitted::material_of;

/// A dark diffuse base under a copper-coloured GGX lacquer. One microfacet lobe cannot represent the lacquer.
pub struct Lacquer {
    facets: Microfacet<Ggx>,
    diffuse: Lambert,
}

impl Default for Lacquer {
    fn default() -> Self {
        let distribution = Ggx::isotropic(DVec2::ZERO, 0.18);
        let fresnel = Fresnel::Schlick(DVec3::new(0.5, 0.3, 0.08));
        Self {
            facets: Microfacet { distribution, masking: Masking::SmithDirectionCorrelated, fresnel },
            diffuse: Lambert { albedo: DVec3::new(0.02, 0.05, 0.08) },
        }
    }
}

impl Lacquer {
    /// Fits the lacquer. The result is always `Some`.
    pub fn fit() -> Option<Fit> {
        fit(&Self::default(), true, &FitOptions::default(), &mut |_| ())
    }
}

impl Brdf for Lacquer {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.facets.eval_cos(wo, wi) + self.diffuse.eval_cos(wo, wi)
    }
}

/// Returns the material of a fit. The relief has these heights about their mean, and a height of 1 is `depth` metres.
pub fn dressed(fit: &Fit, name: &str, heights: HeightMap, depth: f32) -> Material {
    let kept = FitFile { brdf: fit.fitted.clone(), lobes: fit.lobes.clone() };
    let middle = heights.texels.iter().sum::<f32>() / heights.texels.len().max(1) as f32;
    let relief = Relief { map: heights, scale: Some(depth), in_widths: false, middle };
    Material { relief: Some(relief), ..material_of(&kept, name) }
}

/// Returns the material with one Beckmann lobe of the extracted roughness, as in the thesis (Listing 4.4).
pub fn as_beckmann(material: &Material, fit: &Fit) -> Material {
    let alpha = (fit.beckmann.x * fit.beckmann.y - fit.beckmann.z * fit.beckmann.z).max(0.0).sqrt().sqrt();
    Material { fit: None, roughness: Input::constant((alpha as f32).min(1.0)), ..material.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lacquer_is_no_single_lobe() {
        let found = Lacquer::fit().unwrap();
        assert!(found.misfit.rrmse < 0.5 * found.slice_misfit.rrmse, "{:?} {:?}", found.misfit, found.slice_misfit);
        assert!(found.lobes.len() > 1);
    }
}
