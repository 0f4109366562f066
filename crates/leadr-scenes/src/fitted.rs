//! Converts a material measured by `leadr fit` to tables and lobes of its facets. Techniques that do not support them use a roughness and
//! Schlick's Fresnel term.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::DVec3;

use leadr_maps::material::{Anisotropy, Input, Material, RoughnessMeaning, alpha_code, alpha_of};
use leadr_measured::fit_file::{FitFile, masking_name};
use leadr_reflectance::extraction::lobes::fit_lobes;
use leadr_reflectance::facets::ellipse::ellipse_from_roughness;
use leadr_reflectance::facets::fresnel::{Fresnel, schlick_weight};
use leadr_reflectance::facets::gaussian_mixture::{DRAWN_LOBES, Lobe};
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::fitted_table::{FittedTable, lobe_alpha};

/// The largest angle of the Fresnel fit, as a fraction of 90°. Instruments measure little beyond 75°.
const FRESNEL_END: f64 = 75.0 / 90.0;

/// Builds the material of a fit file.
pub fn material_of(fit: &FitFile, name: &str) -> Material {
    let mut material = Material { roughness: Input::constant(1.0), ..Material::new(name) };
    apply_fit(fit, &mut material);
    material
}

/// Replaces the facets and the diffuse term of a material by measured ones. A roughness texture scales the measured slopes, relative to the
/// mean of the texture.
pub fn apply_fit(fit: &FitFile, material: &mut Material) {
    let masking = fit.brdf.facets.masking;
    if masking != Masking::SmithCorrelated {
        let name = &material.name;
        let form = masking_name(masking);
        tracing::warn!(
            "material {name}: its masking, {form}, needs --technique reference; others use smith, so fit it with leadr fit --masking smith"
        );
    }
    // A fit with more lobes than the renderer draws is approximated again.
    let lobes = if fit.lobes.len() > DRAWN_LOBES {
        fit_lobes(&fit.brdf.facets.distribution, DRAWN_LOBES)
    } else {
        fit.lobes.clone()
    };
    let alpha = joint_alpha(&lobes);
    let rgb = |c: DVec3| Input::constant(c.as_vec3().to_array());
    material.base_color = rgb(fit.brdf.diffuse);
    material.metalness = Input::constant(0.0);
    material.f0 = rgb(schlick_f0(&fit.brdf.facets.fresnel));
    material.specular = Input::constant(1.0);
    material.edge_tint = [0.0; 3];
    // The roughness is quantised as in the renderer, so that the renderer does not scale the measured slopes.
    material.fit = Some(Arc::new(FittedTable::new(&fit.brdf, &lobes, alpha_of(alpha_code(alpha as f32)))));
    material.anisotropy = anisotropy_of(&lobes, alpha);
    let mean = mean_alpha(material);
    match material.roughness_meaning {
        RoughnessMeaning::Alpha => material.roughness.factor = alpha as f32 / mean,
        RoughnessMeaning::Perceptual if material.roughness.texture.is_some() => {
            material.roughness.factor = (alpha as f32 / mean).sqrt()
        }
        _ => {
            material.roughness = Input::constant(alpha as f32);
            material.roughness_meaning = RoughnessMeaning::Alpha;
        }
    }
}

/// Returns the RMS `α` of a roughness texture with factor 1, or 1 without a texture.
fn mean_alpha(material: &Material) -> f32 {
    let Some(texture) = &material.roughness.texture else { return 1.0 };
    let (raster, channel) = (&texture.raster, material.roughness.channel);
    let alpha = |x: u32, y: u32| {
        let value = f64::from(raster.value(x, y, channel));
        if material.roughness_meaning == RoughnessMeaning::Alpha { value } else { value * value }
    };
    let texels = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| (x, y)));
    let sum: f64 = texels.map(|(x, y)| alpha(x, y).powi(2)).sum();
    (sum / f64::from(raster.width()) / f64::from(raster.height())).sqrt().max(1e-4) as f32
}

/// Returns one roughness for all lobes (LEADR section 4.1), from the mean variance of the lobes across the anisotropy.
fn joint_alpha(lobes: &[Lobe]) -> f64 {
    let all: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    let squares: f64 = lobes.iter().map(|lobe| lobe.share * lobe_alpha(lobe).powi(2)).sum();
    (squares / all.max(1e-9)).sqrt()
}

/// Returns the larger half-axis of a lobe, the smaller half-axis, and the angle of the larger one.
fn axes(lobe: &Lobe) -> (f64, f64, f64) {
    let ellipse = ellipse_from_roughness(2.0 * lobe.covariance);
    let angle = if ellipse.radii.x >= ellipse.radii.y { ellipse.angle } else { ellipse.angle + FRAC_PI_2 };
    (ellipse.radii.max_element(), ellipse.radii.min_element(), angle)
}

/// Returns the anisotropy of the lobes in excess of their smaller half-axis, in the form of `KHR_materials_anisotropy`.
fn anisotropy_of(lobes: &[Lobe], alpha: f64) -> Option<Anisotropy> {
    let all: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    let beyond = |lobe: &Lobe| {
        let (large, small, _) = axes(lobe);
        lobe.share * (large.min(1.0).powi(2) - small.min(1.0).powi(2))
    };
    let beyond = lobes.iter().map(beyond).sum::<f64>() / all.max(1e-9);
    // The mean covariance gives the direction of the anisotropy.
    let covariance: DVec3 = lobes.iter().map(|lobe| lobe.share * lobe.covariance).sum();
    let (.., angle) = axes(&Lobe { share: 1.0, covariance });
    let along = (alpha * alpha + beyond).sqrt().min(1.0);
    let square = (along - alpha) / (1.0 - alpha).max(1e-3);
    (square > 1e-3).then(|| Anisotropy {
        strength: Input::constant(square.clamp(0.0, 1.0).sqrt() as f32),
        rotation: angle as f32,
        direction: None,
    })
}

/// Returns the F0 whose Schlick form best fits a Fresnel term, by least squares over the cosine-weighted hemisphere.
fn schlick_f0(fresnel: &Fresnel) -> DVec3 {
    const STEPS: u32 = 64;
    let (mut up, mut down) = (DVec3::ZERO, 0.0);
    for i in 0..STEPS {
        let theta = (f64::from(i) + 0.5) / f64::from(STEPS) * FRAC_PI_2 * FRESNEL_END;
        let (sine, cosine) = theta.sin_cos();
        let rest = 1.0 - schlick_weight(cosine);
        // Schlick's term is F = f0 rest + (1 − rest).
        up += sine * cosine * rest * (fresnel.at(cosine) - DVec3::splat(1.0 - rest));
        down += sine * cosine * rest * rest;
    }
    (up / down).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::facets::radial_table::RadialTable;
    use leadr_reflectance::facets::tabulated::Tabulated;
    use leadr_reflectance::materials::fitted::FittedBrdf;
    use leadr_reflectance::materials::microfacet::Microfacet;

    #[test]
    fn schlick_form_is_recovered() {
        for f0 in [DVec3::new(0.04, 0.2, 0.9), DVec3::splat(0.5)] {
            let found = schlick_f0(&Fresnel::Schlick(f0));
            assert!((found - f0).length() < 1e-9, "{found}");
        }
    }

    #[test]
    fn more_lobes_than_the_renderer_draws_are_reduced() {
        let density = |i: usize| (1.0 + 40.0 * (i as f64 / 60.0).powi(4)).powi(-2);
        let table = RadialTable::new(&(0..60).map(density).collect::<Vec<_>>()).unwrap();
        let distribution = Tabulated::Radial(table);
        let lobes = fit_lobes(&distribution, 8);
        assert!(lobes.len() > DRAWN_LOBES);
        let facets = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
        let fit = FitFile { brdf: FittedBrdf { facets, diffuse: DVec3::ZERO }, lobes };
        let table = material_of(&fit, "rough").fit.unwrap();
        assert_eq!(table.lobes() as usize, DRAWN_LOBES);
        // The lobes begin after 14 words, and each lobe has five.
        let shares: f32 = (0..DRAWN_LOBES).map(|lobe| table.words()[14 + 5 * lobe]).sum();
        assert!((shares - 1.0).abs() < 1e-5, "{shares}");
    }

    #[test]
    fn all_of_the_variance_is_kept() {
        let round = |share: f64, alpha: f64| {
            let v = 0.5 * alpha * alpha;
            Lobe { share, covariance: DVec3::new(v, v, 0.0) }
        };
        let alpha = joint_alpha(&[round(0.3, 0.05), round(0.3, 0.06), round(0.4, 0.5)]);
        let mean = 0.3 * (0.05f64.powi(2) + 0.06f64.powi(2)) + 0.4 * 0.25;
        assert!((alpha - mean.sqrt()).abs() < 1e-9, "{alpha}");
        assert!(anisotropy_of(&[round(1.0, 0.2)], 0.2).is_none());
    }

    #[test]
    fn a_stretched_lobe_is_anisotropic_along_its_length() {
        // The lobe has an `α` of 0.4 along the diagonal, and of 0.1 across it.
        let (a, b) = (0.08, 0.005);
        let lobe = Lobe { share: 1.0, covariance: DVec3::new(0.5 * (a + b), 0.5 * (a + b), 0.5 * (a - b)) };
        let alpha = joint_alpha(&[lobe]);
        assert!((alpha - 0.1).abs() < 1e-6, "{alpha}");
        let anisotropy = anisotropy_of(&[lobe], alpha).unwrap();
        let along = alpha + f64::from(anisotropy.strength.factor).powi(2) * (1.0 - alpha);
        assert!(
            (along - 0.4).abs() < 1e-4 && (f64::from(anisotropy.rotation) - FRAC_PI_2 / 2.0).abs() < 1e-5,
            "{along} {}",
            anisotropy.rotation
        );
    }
}
