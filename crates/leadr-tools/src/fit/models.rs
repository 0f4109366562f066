//! The models that are compared with a measured material, in the order of the pictures.

use leadr_reflectance::extraction::fit::Fit;
use leadr_reflectance::extraction::published::{fit_abc, fit_shifted_gamma};
use leadr_reflectance::extraction::samples::Sample;
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::tabulated::Tabulated;
use leadr_reflectance::materials::abc::Abc;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::fitted::FittedBrdf;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_reflectance::materials::shifted_gamma::ShiftedGamma;

/// The names of all models, in the order of the pictures.
pub const NAMES: [&str; 7] = ["fitted", "slice", "thesis", "GGX", "Beckmann", "SGD", "ABC"];

/// The models of one material.
pub struct Models {
    /// The material of the requested extraction.
    pub fitted: FittedBrdf,
    /// The material of the extraction from the slice.
    pub slice: FittedBrdf,
    /// The material of the thesis.
    pub thesis: FittedBrdf,
    /// The slice with GGX facets of the same roughness.
    pub ggx: Microfacet<Ggx>,
    /// The slice with Beckmann facets of the same roughness.
    pub beckmann: Microfacet<Beckmann>,
    /// SGD, only for isotropic materials.
    pub shifted_gamma: Option<ShiftedGamma>,
    /// ABC, only for isotropic materials.
    pub abc: Option<Abc>,
}

impl Models {
    /// Fits SGD and ABC to the samples, and takes the other models from the fit. This takes seconds.
    pub fn new(fit: &Fit, samples: &[Sample]) -> Self {
        let (shifted_gamma, abc) = match &fit.slice.facets.distribution {
            Tabulated::Radial(slopes) => (fit_shifted_gamma(samples, slopes), fit_abc(samples, slopes)),
            Tabulated::Polar(_) => (None, None),
        };
        Self {
            fitted: fit.fitted.clone(),
            slice: fit.slice.clone(),
            thesis: fit.thesis.clone(),
            ggx: fit.as_ggx(),
            beckmann: fit.as_beckmann(),
            shifted_gamma,
            abc,
        }
    }

    /// Returns the models that the material has, with their names.
    pub fn named(&self) -> Vec<(&'static str, &(dyn Brdf + Sync))> {
        let always: [&(dyn Brdf + Sync); 5] = [&self.fitted, &self.slice, &self.thesis, &self.ggx, &self.beckmann];
        let published = [
            self.shifted_gamma.as_ref().map(|model| model as &(dyn Brdf + Sync)),
            self.abc.as_ref().map(|model| model as &(dyn Brdf + Sync)),
        ];
        let all = always.into_iter().map(Some).chain(published);
        NAMES.into_iter().zip(all).filter_map(|(name, model)| Some((name, model?))).collect()
    }
}
