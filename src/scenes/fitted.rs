//! A measured material, as `leadr fit` keeps it, for the renderer: its slopes as two Gaussian lobes, its Fresnel term in Schlick's form.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::maps::material::{Anisotropy, Input, Material, RoughnessMeaning};
use crate::measured::fit_file::FitFile;
use crate::reflectance::facets::ellipse::ellipse_from_roughness;
use crate::reflectance::facets::fresnel::{Fresnel, schlick_weight};
use crate::reflectance::facets::gaussian_mixture::Lobe;
use crate::reflectance::facets::mixed_roughness::{MixedRoughness, two_classes};

/// Angles over which the Fresnel term is fitted; beyond them instruments see little.
const FRESNEL_END: f64 = 75.0 / 90.0;

/// The material of a fit.
#[must_use]
pub fn material_of(fit: &FitFile, name: &str) -> Material {
    let lobes = two_lobes(&fit.lobes);
    let alpha = lobes.joint_alpha();
    let rgb = |c: DVec3| Input::constant(c.as_vec3().to_array());
    Material {
        base_color: rgb(fit.brdf.diffuse),
        f0: rgb(schlick_f0(&fit.brdf.facets.fresnel)),
        roughness: Input::constant(alpha as f32),
        roughness_meaning: RoughnessMeaning::Alpha,
        lobes: (lobes.share > 0.0).then_some(lobes),
        anisotropy: brushed(&fit.lobes, alpha),
        ..Material::new(name)
    }
}

/// Half-axes of a lobe: the larger, the lesser, and the angle of the larger.
fn axes(lobe: &Lobe) -> (f64, f64, f64) {
    let ellipse = ellipse_from_roughness(2.0 * lobe.covariance);
    let angle = if ellipse.radii.x >= ellipse.radii.y { ellipse.angle } else { ellipse.angle + FRAC_PI_2 };
    (ellipse.radii.max_element(), ellipse.radii.min_element(), angle)
}

/// Two lobes, as wide as the lesser half-axes: the groups of lobes that differ least inside.
fn two_lobes(lobes: &[Lobe]) -> MixedRoughness {
    let mut all: Vec<(f64, f64)> = lobes.iter().map(|lobe| (axes(lobe).1.clamp(1e-4, 1.0), lobe.share)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (alphas, weights): (Vec<f64>, Vec<f64>) = all.iter().copied().unzip();
    let threshold = two_classes(&alphas, &weights).unwrap_or(f64::INFINITY);
    let sums = |rough: bool| {
        all.iter()
            .filter(|(alpha, _)| (*alpha >= threshold) == rough)
            .fold((0.0, 0.0), |(share, square), (alpha, weight)| (share + weight, square + weight * alpha * alpha))
    };
    let ((smooth, smooth_square), (rough, rough_square)) = (sums(false), sums(true));
    let smooth_alpha = (smooth_square / smooth.max(1e-9)).sqrt();
    let rough_alpha = if rough > 0.0 { (rough_square / rough).sqrt() } else { smooth_alpha };
    MixedRoughness { share: rough / (smooth + rough).max(1e-9), smooth_alpha, rough_alpha }
}

/// What the lobes have along one direction beyond their lesser half-axis, in the form of `KHR_materials_anisotropy`.
fn brushed(lobes: &[Lobe], alpha: f64) -> Option<Anisotropy> {
    let weight = |lobe: &Lobe| lobe.share;
    let all: f64 = lobes.iter().map(weight).sum();
    let mean =
        |of: &dyn Fn(&Lobe) -> f64| lobes.iter().map(|lobe| weight(lobe) * of(lobe)).sum::<f64>() / all.max(1e-9);
    let beyond = mean(&|lobe| {
        let (large, small, _) = axes(lobe);
        large.min(1.0).powi(2) - small.min(1.0).powi(2)
    });
    // The direction of the mean covariance.
    let covariance: DVec3 = lobes.iter().map(|lobe| weight(lobe) * lobe.covariance).sum();
    let (.., angle) = axes(&Lobe { share: 1.0, covariance });
    let along = (alpha * alpha + beyond).sqrt().min(1.0);
    let square = (along - alpha) / (1.0 - alpha).max(1e-3);
    (square > 1e-3).then(|| Anisotropy {
        strength: Input::constant(square.clamp(0.0, 1.0).sqrt() as f32),
        rotation: angle as f32,
        direction: None,
    })
}

/// The reflectance at normal incidence whose Schlick form is nearest to a Fresnel term, by least squares over the cosine-weighted hemisphere.
fn schlick_f0(fresnel: &Fresnel) -> DVec3 {
    const STEPS: u32 = 64;
    let (mut up, mut down) = (DVec3::ZERO, 0.0);
    for i in 0..STEPS {
        let theta = (f64::from(i) + 0.5) / f64::from(STEPS) * FRAC_PI_2 * FRESNEL_END;
        let (sine, cosine) = theta.sin_cos();
        let rest = 1.0 - schlick_weight(cosine);
        // F = f0 rest + (1 − rest)
        up += sine * cosine * rest * (fresnel.at(cosine) - DVec3::splat(1.0 - rest));
        down += sine * cosine * rest * rest;
    }
    (up / down).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schlicks_form_is_found_again() {
        for f0 in [DVec3::new(0.04, 0.2, 0.9), DVec3::splat(0.5)] {
            let found = schlick_f0(&Fresnel::Schlick(f0));
            assert!((found - f0).length() < 1e-9, "{found}");
        }
    }

    #[test]
    fn lobes_become_two() {
        let round = |share: f64, alpha: f64| {
            let v = 0.5 * alpha * alpha;
            Lobe { share, covariance: DVec3::new(v, v, 0.0) }
        };
        let one = two_lobes(&[round(0.4, 0.2), round(0.6, 0.21)]);
        assert_eq!(one.share, 0.0);
        let two = two_lobes(&[round(0.3, 0.05), round(0.3, 0.06), round(0.4, 0.5)]);
        assert!((two.share - 0.4).abs() < 1e-9 && (two.rough_alpha - 0.5).abs() < 1e-9, "{two:?}");
        assert!((two.smooth_alpha - (0.5f64 * (0.05f64.powi(2) + 0.06f64.powi(2))).sqrt()).abs() < 1e-9, "{two:?}");
        // All of the variance is kept.
        let mean = 0.3 * (0.05f64.powi(2) + 0.06f64.powi(2)) + 0.4 * 0.25;
        assert!((two.joint_alpha() - mean.sqrt()).abs() < 1e-9);
        assert!(brushed(&[round(1.0, 0.2)], 0.2).is_none());
    }

    #[test]
    fn a_stretched_lobe_is_brushed_along_its_length() {
        // 0.4 along the diagonal, 0.1 across.
        let (a, b) = (0.08, 0.005);
        let lobe = Lobe { share: 1.0, covariance: DVec3::new(0.5 * (a + b), 0.5 * (a + b), 0.5 * (a - b)) };
        let alpha = two_lobes(&[lobe]).joint_alpha();
        assert!((alpha - 0.1).abs() < 1e-6, "{alpha}");
        let brush = brushed(&[lobe], alpha).unwrap();
        let along = alpha + f64::from(brush.strength.factor).powi(2) * (1.0 - alpha);
        assert!(
            (along - 0.4).abs() < 1e-4 && (f64::from(brush.rotation) - FRAC_PI_2 / 2.0).abs() < 1e-5,
            "{along} {}",
            brush.rotation
        );
    }
}
