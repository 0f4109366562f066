//! A synthetic material for measurement and fitting, and the use of fits as materials of displaced surfaces.

use glam::{DVec2, DVec3};

use leadr_maps::HeightMap;
use leadr_maps::material::{Input, Material, Relief};
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::extraction::fit::{Fit, FitOptions, fit};
use leadr_reflectance::extraction::roughness::beckmann_roughness;
use leadr_reflectance::facets::ellipse::{Bivariate, covariance_from_roughness, roughness_from_bivariate};
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::facets::gaussian_mixture::Lobe;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::lambert::Lambert;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_scenes::fitted::{apply_fit, material_of};

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

/// A satin: a green diffuse base under anisotropic GGX facets whose axes are rotated.
pub struct Satin {
    facets: Microfacet<Ggx>,
    diffuse: Lambert,
}

impl Default for Satin {
    fn default() -> Self {
        let roughness = roughness_from_bivariate(&Bivariate::new(DVec2::new(0.45, 0.3), 0.5));
        let fresnel = Fresnel::Schlick(DVec3::new(0.3, 0.35, 0.25));
        Self {
            facets: Microfacet {
                distribution: Ggx::new(DVec2::ZERO, roughness),
                masking: Masking::SmithDirectionCorrelated,
                fresnel,
            },
            diffuse: Lambert { albedo: DVec3::new(0.03, 0.1, 0.04) },
        }
    }
}

impl Brdf for Satin {
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

/// Returns the material as the thesis filters it (5.1): the fit of the thesis with its Fresnel table, and one Beckmann lobe with the second
/// moments of its slopes (Listing 4.4).
pub fn as_thesis(material: &Material, fit: &Fit) -> Material {
    let lobe =
        Lobe { share: 1.0, covariance: covariance_from_roughness(beckmann_roughness(&fit.thesis.facets.distribution)) };
    let mut material = material.clone();
    apply_fit(&FitFile { brdf: fit.thesis.clone(), lobes: vec![lobe] }, &mut material);
    material
}

/// Returns the material with one Beckmann lobe of the extracted roughness and Schlick's Fresnel term, without the tables of the fit.
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

    #[test]
    fn the_thesis_has_one_lobe_and_its_fresnel_table() {
        let found = Lacquer::fit().unwrap();
        let flat = HeightMap::new(1, 1, vec![0.0]).unwrap();
        let lobes = dressed(&found, "lacquer", flat, 1.0);
        let one = as_thesis(&lobes, &found);
        let table = one.fit.unwrap();
        assert_eq!(table.lobes(), 1);
        let alpha = found.beckmann.x.sqrt() as f32;
        assert!((one.roughness.factor / alpha - 1.0).abs() < 1e-3, "{} {alpha}", one.roughness.factor);
        // Backscattering sees the diffuse base as facets, so the thesis has none.
        assert_eq!(one.base_color.factor, [0.0; 3]);
        assert!(one.f0.factor != lobes.f0.factor && lobes.relief == one.relief);
    }
}
