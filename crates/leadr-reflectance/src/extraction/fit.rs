//! The complete fit of a material: extraction, Fresnel term, refinement, equivalent roughnesses, and lobes.

use std::f64::consts::TAU;

use glam::DVec3;

use super::fresnel::{slice_fresnel, thesis_fresnel};
use super::lobes::fit_lobes;
use super::parametric::nearest;
use super::power_iteration::{Backscattering, Extracted, extract_polar, extract_radial};
use super::refinement::refine;
use super::roughness::{beckmann_roughness, ggx_roughness};
use super::samples::{Misfit, direction, misfit, samples};
use crate::color::luminance;
use crate::facets::beckmann::Beckmann;
use crate::facets::ellipse::covariance_from_roughness;
use crate::facets::fresnel::{Fresnel, FresnelTable};
use crate::facets::gaussian_mixture::Lobe;
use crate::facets::ggx::Ggx;
use crate::facets::parametric_curve::{Family, ParametricCurve};
use crate::facets::radial_table::angle_at;
use crate::facets::slope_distribution::SlopeDistribution;
use crate::facets::tabulated::Tabulated;
use crate::masking::variants::Masking;
use crate::materials::brdf::Brdf;
use crate::materials::fitted::FittedBrdf;
use crate::materials::microfacet::Microfacet;

/// The method that extracts the facets of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extraction {
    /// The slopes, the Fresnel term and a diffuse base are refined over all directions.
    #[default]
    Refined,
    /// The slopes are those of backscattering, and the Fresnel term that of [`slice_fresnel`]. Use it if only backscattering is known.
    Slice,
    /// The slopes are those of backscattering, and the Fresnel term that of [`thesis_fresnel`] (thesis algorithm 2).
    Thesis,
}

/// The options of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FitOptions {
    /// The masking-shadowing model of the backscattering. With [`Backscattering::Smith`] and [`Extraction::Refined`], the fit selects the
    /// better of the two Smith models.
    pub hiding: Backscattering,
    /// The number of angles at which backscattering is sampled, at least 3.
    pub angles: usize,
    /// The number of azimuths for an anisotropic material, at least 4.
    pub azimuths: usize,
    /// The number of Gaussian lobes, at most [`MOST_LOBES`](crate::facets::gaussian_mixture::MOST_LOBES).
    pub lobes: usize,
    /// The method that gives [`Fit::fitted`].
    pub extraction: Extraction,
}

impl Default for FitOptions {
    /// Returns 90 angles and 90 azimuths, as in the thesis, with four lobes and with refinement over all directions, which the thesis does
    /// not have.
    fn default() -> Self {
        Self { hiding: Backscattering::Smith, angles: 90, azimuths: 90, lobes: 4, extraction: Extraction::Refined }
    }
}

/// A material fitted by microfacets.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The requested extraction.
    pub extraction: Extraction,
    /// The masking-shadowing model of the backscattering.
    pub backscattering: Backscattering,
    /// The slopes and `F₀`, extracted from backscattering only.
    pub extracted: Extracted<Tabulated>,
    /// The Beckmann roughness matrix of the extracted slopes, in `α²` terms.
    pub beckmann: DVec3,
    /// The GGX roughness matrix of the extracted slopes, in `α²` terms.
    pub ggx: DVec3,
    /// The material of [`Extraction::Thesis`]. Its Fresnel term can be a residual above 1.
    pub thesis: FittedBrdf,
    /// The material of [`Extraction::Slice`].
    pub slice: FittedBrdf,
    /// The material of the requested extraction.
    pub fitted: FittedBrdf,
    /// The Gaussian lobes of the slopes of [`Self::fitted`].
    pub lobes: Vec<Lobe>,
    /// The nearest published parametric curves: a shifted gamma distribution and an ABC curve. Only isotropic slopes have these curves.
    pub curves: Option<[ParametricCurve; 2]>,
    /// The misfit of [`Self::thesis`] to the measured material.
    pub thesis_misfit: Misfit,
    /// The misfit of [`Self::slice`] to the measured material.
    pub slice_misfit: Misfit,
    /// The misfit of [`Self::fitted`] to the measured material.
    pub misfit: Misfit,
}

/// A step of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The power iteration for the slopes.
    Slopes,
    /// The extraction of the Fresnel term.
    Fresnel,
    /// The refinement over all directions.
    Refinement,
    /// The fit of Gaussian lobes to the slopes.
    Lobes,
}

impl Fit {
    /// Returns the material with Gaussian slopes that have the same second moments (thesis listing 4.4). The Fresnel term is that of
    /// [`Self::thesis`] if this extraction was requested, and that of [`Self::slice`] otherwise.
    pub fn as_beckmann(&self) -> Microfacet<Beckmann> {
        let covariance = covariance_from_roughness(self.beckmann);
        self.with_slopes(Beckmann::new(self.extracted.slopes.mean_slope(), covariance))
    }

    /// Returns the material with GGX slopes that have the same mean absolute values (thesis listing 4.5). The Fresnel term is that of
    /// [`Self::as_beckmann`].
    pub fn as_ggx(&self) -> Microfacet<Ggx> {
        self.with_slopes(Ggx::new(self.extracted.slopes.mean_slope(), self.ggx))
    }

    fn with_slopes<D>(&self, distribution: D) -> Microfacet<D> {
        let of = if self.extraction == Extraction::Thesis { &self.thesis } else { &self.slice };
        let Microfacet { masking, fresnel, .. } = &of.facets;
        Microfacet { distribution, masking: *masking, fresnel: fresnel.clone() }
    }
}

/// Fits a material. `watch` is called at the start of each step.
///
/// Returns `None` if the material backscatters no light.
pub fn fit(brdf: &dyn Brdf, isotropic: bool, options: &FitOptions, watch: &mut dyn FnMut(Step)) -> Option<Fit> {
    watch(Step::Slopes);
    let angles = options.angles.max(3);
    let azimuths = options.azimuths.max(4);
    let back = |i: usize, phi: f64| {
        let o = direction(angle_at(i as f64 / angles as f64), phi);
        luminance(brdf.eval(o, o))
    };
    let rows: Vec<Vec<f64>> = (0..if isotropic { 1 } else { azimuths })
        .map(|k| (0..angles).map(|i| back(i, TAU * k as f64 / azimuths as f64)).collect())
        .collect();
    let extract = |backscattering| -> Option<Extracted<Tabulated>> {
        if isotropic {
            extract_radial(&rows[0], backscattering).map(|found| found.map(Tabulated::Radial))
        } else {
            extract_polar(&rows, backscattering).map(|found| found.map(Tabulated::Polar))
        }
    };
    let masking = options.hiding.masking();
    let all = samples(brdf, isotropic);
    let refines = options.extraction == Extraction::Refined;
    let mut candidates = match options.hiding {
        // Both Smith models can fit the backscattering, so a choice between the two needs other directions.
        Backscattering::Smith if refines => vec![Backscattering::Smith, Backscattering::SmithRendered],
        other => vec![other],
    }
    .into_iter();
    let (mut backscattering, mut extracted) = candidates.next().and_then(|kind| Some((kind, extract(kind)?)))?;
    watch(Step::Fresnel);
    let thesis = with_fresnel(&extracted.slopes, masking, thesis_fresnel(brdf, &extracted.slopes, masking, angles));
    let thesis_misfit = misfit(&all, &thesis);
    let of_slice = |slopes: &Tabulated| {
        let material = with_fresnel(slopes, masking, slice_fresnel(brdf, slopes, masking, angles));
        let wrong = misfit(&all, &material);
        (material, wrong)
    };
    let (mut slice, mut slice_misfit) = of_slice(&extracted.slopes);
    for kind in candidates {
        let found = extract(kind)?;
        let (material, wrong) = of_slice(&found.slopes);
        // Measured materials are close to both Smith models, but rendered materials match one model exactly.
        if wrong.divergence < RENDERED * slice_misfit.divergence {
            (backscattering, extracted, slice, slice_misfit) = (kind, found, material, wrong);
        }
    }
    let (mut fitted, mut best) = match options.extraction {
        Extraction::Thesis => (thesis.clone(), thesis_misfit),
        Extraction::Slice | Extraction::Refined => (slice.clone(), slice_misfit),
    };
    if refines && slice_misfit.divergence > PERFECT {
        watch(Step::Refinement);
        let refined = refine(&all, &slice);
        let wrong = misfit(&all, &refined);
        if wrong.divergence < best.divergence {
            (fitted, best) = (refined, wrong);
        }
    }
    watch(Step::Lobes);
    let lobes = fit_lobes(&fitted.facets.distribution, options.lobes);
    let curves = match &fitted.facets.distribution {
        Tabulated::Radial(table) => Some([Family::ShiftedGamma, Family::Abc].map(|family| nearest(table, family))),
        Tabulated::Polar(_) => None,
    };
    Some(Fit {
        extraction: options.extraction,
        backscattering,
        beckmann: beckmann_roughness(&extracted.slopes),
        ggx: ggx_roughness(&extracted.slopes),
        extracted,
        thesis,
        slice,
        fitted,
        lobes,
        curves,
        thesis_misfit,
        slice_misfit,
        misfit: best,
    })
}

/// The divergence below which refinement is skipped.
const PERFECT: f64 = 1e-6;
/// The factor by which the Smith model of renderers must reduce the divergence to be selected.
const RENDERED: f64 = 0.5;

fn with_fresnel(slopes: &Tabulated, masking: Masking, fresnel: FresnelTable) -> FittedBrdf {
    let facets = Microfacet { distribution: slopes.clone(), masking, fresnel: Fresnel::Tabulated(fresnel) };
    FittedBrdf { facets, diffuse: DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::ellipse::{Bivariate, bivariate_from_roughness, roughness_from_bivariate};
    use crate::materials::lambert::Lambert;
    use glam::DVec2;

    fn fit_of(brdf: &dyn Brdf, isotropic: bool) -> Fit {
        fit(brdf, isotropic, &FitOptions::default(), &mut |_| ()).unwrap()
    }

    /// Returns Schlick's approximation with a different F0 for each channel.
    fn fresnel() -> Fresnel {
        Fresnel::Schlick(DVec3::new(0.9, 0.6, 0.3))
    }

    #[test]
    fn rendered_materials_come_back() {
        let masking = Masking::SmithCorrelated;
        for alpha in [0.02, 0.1, 0.5] {
            let v = 0.5 * alpha * alpha;
            let gaussian = Beckmann::new(DVec2::ZERO, DVec3::new(v, v, 0.0));
            let beckmann = fit_of(&Microfacet { distribution: gaussian, masking, fresnel: fresnel() }, true);
            let ggx = fit_of(
                &Microfacet { distribution: Ggx::isotropic(DVec2::ZERO, alpha), masking, fresnel: fresnel() },
                true,
            );
            for (fit, found) in [(&beckmann, beckmann.beckmann.x), (&ggx, ggx.ggx.x)] {
                assert!((found.sqrt() / alpha - 1.0).abs() < 1e-4, "{alpha}: {}", found.sqrt());
                assert!(fit.misfit.rrmse < 1e-3 && fit.misfit.perceptual < 2e-3, "{alpha}: {:?}", fit.misfit);
                let f0 = fit.fitted.facets.fresnel.at(1.0);
                assert!((f0 - fresnel().at(1.0)).length() < 1e-3, "{alpha}: {f0}");
            }
        }
        let (alpha, rho) = (DVec2::new(0.4, 0.1), -0.5);
        let a = roughness_from_bivariate(&Bivariate::new(alpha, rho));
        let ggx = fit_of(&Microfacet { distribution: Ggx::new(DVec2::ZERO, a), masking, fresnel: fresnel() }, false);
        let found = bivariate_from_roughness(ggx.ggx);
        assert!((found.alpha / alpha - DVec2::ONE).length() < 1e-2 && (found.rho - rho).abs() < 0.01, "{found:?}");
    }

    /// The fit recovers a diffuse term, which backscattering alone attributes to facets.
    #[test]
    fn diffuse_terms_are_separated_from_facets() {
        struct Paint(Microfacet<Ggx>);
        impl Brdf for Paint {
            fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
                self.0.eval_cos(wo, wi) + Lambert { albedo: DVec3::new(0.4, 0.2, 0.1) }.eval_cos(wo, wi)
            }
        }
        let fit = fit_of(&Paint(varnish()), true);
        println!("diffuse {}, misfit {:?}, slice {:?}", fit.fitted.diffuse, fit.misfit, fit.slice_misfit);
        assert!((fit.fitted.diffuse - DVec3::new(0.4, 0.2, 0.1)).length() < 0.02, "{}", fit.fitted.diffuse);
        assert!(
            fit.misfit.rrmse < 0.2 * fit.slice_misfit.rrmse
                && fit.misfit.perceptual < 0.2 * fit.slice_misfit.perceptual
        );
        let with = |extraction| {
            let options = FitOptions { extraction, ..FitOptions::default() };
            super::fit(&Paint(varnish()), true, &options, &mut |_| ()).unwrap()
        };
        let slice = with(Extraction::Slice);
        assert_eq!((slice.misfit, &slice.fitted), (slice.slice_misfit, &slice.slice));
        let thesis = with(Extraction::Thesis);
        assert_eq!((thesis.misfit, &thesis.fitted), (thesis.thesis_misfit, &thesis.thesis));
        assert_eq!(thesis.thesis_misfit, fit.thesis_misfit);
        // GGX and Beckmann have the Fresnel term of the requested extraction.
        assert_eq!(slice.as_ggx().fresnel, slice.slice.facets.fresnel);
        assert_eq!(thesis.as_ggx().fresnel, thesis.thesis.facets.fresnel);
        assert_eq!(thesis.as_beckmann().fresnel, thesis.thesis.facets.fresnel);
        assert_ne!(thesis.as_ggx().fresnel, slice.as_ggx().fresnel);
    }

    fn varnish() -> Microfacet<Ggx> {
        let distribution = Ggx::isotropic(DVec2::ZERO, 0.2);
        Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Schlick(DVec3::splat(0.05)) }
    }

    /// Under Smith's masking, the throughput of tabulated facets is at most 1. Without shadowing, they conserve all energy.
    #[test]
    fn samples_are_worth_what_they_reflect() {
        let distribution = Ggx::isotropic(DVec2::ZERO, 0.4);
        let specular = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
        let slopes = fit_of(&specular, true).extracted.slopes;
        for (masking, theta) in [Masking::SmithCorrelated, Masking::SmithUnshadowed]
            .into_iter()
            .flat_map(|m| [0.2, 0.9, 1.4].map(|t| (m, t)))
        {
            let facets = Microfacet { distribution: slopes.clone(), masking, fresnel: Fresnel::Ideal };
            let wo = DVec3::new(f64::sin(theta), 0.0, f64::cos(theta));
            let (n, mut sum) = (60, 0.0);
            for i in 0..n * n {
                let u = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
                let Some(sample) = facets.sample(wo, u) else { continue };
                assert!(sample.throughput.x <= 1.0 + 1e-9, "{masking:?} {theta}: {}", sample.throughput);
                assert!((sample.pdf / facets.pdf(wo, sample.wi) - 1.0).abs() < 1e-6);
                sum += sample.throughput.x / f64::from(n * n);
            }
            if masking == Masking::SmithUnshadowed {
                assert!((sum - 1.0).abs() < 0.01, "{theta}: {sum}");
            }
        }
    }

    #[test]
    fn non_backscattering_material_has_no_fit() {
        let black = Lambert { albedo: DVec3::ZERO };
        assert!(fit(&black, true, &FitOptions::default(), &mut |_| ()).is_none());
        assert!(
            fit(&black, false, &FitOptions { angles: 0, azimuths: 0, ..FitOptions::default() }, &mut |_| ()).is_none()
        );
    }
}
