//! Reflection of a rough diffuse base, relative to Lambert's law.
//!
//! All functions return `π f_r / ρ`, where `ρ` is the albedo of the base. The functions named `…_albedo` return the mean of this value over
//! the cosine-weighted hemisphere of the other direction. Directions are in the tangent frame of a facet of the relief. `alpha` is the
//! roughness of the base.

use super::energy::SplitAlbedo;
use super::microfacet::half_vector;
use super::multiscattering::chan_diffuse;
use crate::facets::fresnel::schlick_weight;
use crate::facets::gloss::Gloss;
use crate::limits::{at_least, unit};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// The model of the diffuse base. The numbers equal the `LEADR_DIFFUSE_` constants in `leadr/materials/diffuse_models.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiffuseModel {
    /// Lambert's law below Fresnel's term.
    Lambert = 0,
    /// Oren and Nayar's rough facets below Fresnel's term ([`oren_nayar`]).
    OrenNayar = 1,
    /// Burley's model ([`disney_diffuse`]).
    Disney = 2,
    /// Chan's published fit ([`chan_diffuse`]).
    CallOfDuty = 3,
    /// The light between facets, both specular and diffuse ([`super::energy`], [`super::multiscattering`]).
    Multiscattering = 4,
    /// A linear blend of the specular facets and Lambert's law, with the albedo as the share of the law (thesis eq. 5.4).
    Blend = 5,
    /// Lambert's law for the light that the coat lets through toward the base, without the loss on the way out
    /// ([`conserving_diffuse`]). It is not reciprocal.
    Conserving = 6,
}

impl DiffuseModel {
    /// All models, in numeric order.
    pub const ALL: [Self; 7] = [
        Self::Lambert,
        Self::OrenNayar,
        Self::Disney,
        Self::CallOfDuty,
        Self::Multiscattering,
        Self::Blend,
        Self::Conserving,
    ];

    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lambert => "lambert",
            Self::OrenNayar => "oren-nayar",
            Self::Disney => "disney",
            Self::CallOfDuty => "call-of-duty",
            Self::Multiscattering => "multiscattering",
            Self::Blend => "blend",
            Self::Conserving => "conserving",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Lambert => "Lambert's law below the Fresnel term",
            Self::OrenNayar => "Rough facets that light each other twice (Oren & Nayar 1994, Fujii 2012)",
            Self::Disney => "Burley's model of 2012; its albedo exceeds 1 where rough",
            Self::CallOfDuty => "Chan's fit of 2018 for a coat of F0 .04; its albedo exceeds 1 where rough",
            Self::Multiscattering => "All light between facets, specular and diffuse, without loss or gain",
            Self::Blend => "A blend of the specular term and Lambert's law, by the albedo (thesis eq. 5.4)",
            Self::Conserving => "Lambert's law for the light that the coat lets in (Chan 2018, listing 5)",
        }
    }
}

/// Returns Oren and Nayar's coefficients `A` and `B` (Fujii 2012, the improved qualitative model). The standard deviation of the tilt of
/// facets is taken as `arctan α`, because `α²` is the mean square of a Beckmann slope.
fn oren_nayar_terms(alpha: f64, albedo: DVec3) -> (DVec3, f64) {
    let square = unit(alpha).atan().powi(2);
    let a = 1.0 - 0.5 * square / (square + 0.33) + albedo * (0.17 * square / (square + 0.13));
    (a, 0.45 * square / (square + 0.09))
}

/// Returns Oren and Nayar's model (Oren and Nayar 1994; Fujii 2012). `albedo` is linear RGB from 0 to 1.
pub fn oren_nayar(wo: DVec3, wi: DVec3, alpha: f64, albedo: DVec3) -> DVec3 {
    let (a, b) = oren_nayar_terms(alpha, albedo);
    let s = wo.x * wi.x + wo.y * wi.y;
    let t = if s > 0.0 { at_least(wo.z.max(wi.z), 1e-6) } else { 1.0 };
    a + b * s / t
}

/// Returns the directional albedo of [`oren_nayar`].
pub fn oren_nayar_albedo(cosine: f64, alpha: f64, albedo: DVec3) -> DVec3 {
    let (a, b) = oren_nayar_terms(alpha, albedo);
    let c = at_least(unit(cosine), 1e-4);
    let s = ((1.0 - c) * (1.0 + c)).sqrt();
    let g = s * (c.acos() - s * c) + 2.0 / 3.0 * (s / c * (1.0 - s * s * s) - s);
    a + b * FRAC_1_PI * g
}

/// Returns Burley's diffuse model (2012), whose roughness is `√α`. The model contains its own loss to the coat.
pub fn disney_diffuse(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    let grazing = unit(alpha).sqrt() * (1.0 + wo.dot(wi)) - 0.5;
    (1.0 + grazing * schlick_weight(wo.z)) * (1.0 + grazing * schlick_weight(wi.z))
}

/// Returns the directional albedo of [`disney_diffuse`]. The moments of Schlick's weight make it a closed form.
pub fn disney_albedo(cosine: f64, alpha: f64) -> f64 {
    let (c, r) = (unit(cosine), unit(alpha).sqrt());
    let (p, w, q) = (r - 0.5, schlick_weight(c), r * c);
    let both = p * p / 21.0 + p * q / 42.0 + q * q / 252.0 + r * r * (1.0 - c * c) * 11.0 / 504.0;
    1.0 + p / 21.0 + q / 84.0 + w * (p + 2.0 / 3.0 * q + both)
}

/// Returns the directional albedo of [`chan_diffuse`], a fit with errors of up to 0.004.
pub fn chan_albedo(cosine: f64, gloss: f64) -> f64 {
    let (c, g) = (unit(cosine), unit(gloss));
    let rough = 0.704501 + c * (0.193849 + c * (0.01657 - 0.003074 * c));
    let smooth = (1.0 - 0.75 / 21.0) * (1.0 - 0.75 * schlick_weight(c));
    let rate = (73.2 * g - 21.2).max(8.9) - 8.9;
    let bump = 0.0183685 * (10.9178 / (rate + 10.9178)).powi(4) * (1.0 + 2.13598 * c).powf(-1.69872 - 0.319595 * rate);
    rough + (smooth - rough) * (2.2 * g - 0.5).clamp(0.0, 1.0) + (34.5 * g * g - 59.0 * g + 24.5) * bump
}

/// Returns the value of [`DiffuseModel::Conserving`]. `coat` is the albedo of the coat toward the light ([`EnergyTable::albedo`]), or its
/// mean, which gives the directional albedo of the base.
///
/// [`EnergyTable::albedo`]: super::energy::EnergyTable::albedo
pub fn conserving_diffuse(f0: DVec3, coat: SplitAlbedo) -> DVec3 {
    DVec3::ONE - coat.of(f0)
}

/// Returns the value of a model. The bases of [`DiffuseModel::Multiscattering`] and [`DiffuseModel::Conserving`] need the tables of their
/// coat, so they count as Lambertian here.
pub fn diffuse_value(model: DiffuseModel, wo: DVec3, wi: DVec3, alpha: f64, albedo: DVec3) -> DVec3 {
    match model {
        DiffuseModel::OrenNayar => oren_nayar(wo, wi, alpha, albedo),
        DiffuseModel::Disney => DVec3::splat(disney_diffuse(wo, wi, alpha)),
        DiffuseModel::CallOfDuty => {
            let h = half_vector(wo, wi);
            DVec3::splat(at_least(chan_diffuse(wi.z, wo.z, h.z, wi.dot(h), Gloss::Wwii.gloss(alpha)), 0.0))
        }
        DiffuseModel::Lambert | DiffuseModel::Multiscattering | DiffuseModel::Blend | DiffuseModel::Conserving => {
            DVec3::ONE
        }
    }
}

/// Returns the directional albedo of [`diffuse_value`].
pub fn diffuse_model_albedo(model: DiffuseModel, cosine: f64, alpha: f64, albedo: DVec3) -> DVec3 {
    match model {
        DiffuseModel::OrenNayar => oren_nayar_albedo(cosine, alpha, albedo),
        DiffuseModel::Disney => DVec3::splat(disney_albedo(cosine, alpha)),
        DiffuseModel::CallOfDuty => DVec3::splat(chan_albedo(cosine, Gloss::Wwii.gloss(alpha))),
        DiffuseModel::Lambert | DiffuseModel::Multiscattering | DiffuseModel::Blend | DiffuseModel::Conserving => {
            DVec3::ONE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{frame_about, to_frame};
    use crate::materials::energy::{EnergyTable, entered};
    use crate::materials::multiscattering::{BOUNCES, facet_albedo, multiscattering_diffuse};
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::{facet_area, grid_nodes, normal_of_slope, slope_at, slope_cholesky};
    use crate::visible::mapped::mapped_slopes;
    use crate::visible::slopes::visible_slopes;
    use glam::{DVec2, Vec3Swizzles as _};
    use std::f64::consts::PI;

    const MODELS: [DiffuseModel; 3] = [DiffuseModel::OrenNayar, DiffuseModel::Disney, DiffuseModel::CallOfDuty];

    fn direction(c: f64, phi: f64) -> DVec3 {
        let s = ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), c)
    }

    /// Computes `∫ f c dω / π` over the hemisphere of lights, with more nodes at grazing angles.
    fn hemisphere(f: impl Fn(DVec3) -> DVec3) -> DVec3 {
        let azimuths = composite_gauss(0.0, PI, 4, 12);
        composite_gauss(0.0, 1.0, 6, 12)
            .into_iter()
            .map(|(u, w)| {
                let ring: DVec3 = azimuths.iter().map(|(phi, v)| 2.0 * v * f(direction(u * u, *phi))).sum();
                ring * (w * 2.0 * u * u * u)
            })
            .sum::<DVec3>()
            / PI
    }

    /// The value of a base of albedo .5, for [`DiffuseModel::Multiscattering`] under a coat of F0 .04.
    fn grey_value(model: DiffuseModel, table: &EnergyTable, wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
        let grey = DVec3::splat(0.5);
        if model != DiffuseModel::Multiscattering {
            return diffuse_value(model, wo, wi, alpha, grey).x;
        }
        let (f0, average, bounces) = (DVec3::splat(0.04), table.average(alpha), BOUNCES.at(alpha));
        let [o, i] = [wo, wi].map(|w| entered(f0, table.albedo(alpha, w.z), average.ideal));
        let (facets, mean) = (facet_albedo(bounces, grey), entered(f0, average, average.ideal));
        2.0 * PI * multiscattering_diffuse(wo, wi, bounces, f0, facets, o, i, mean).x
    }

    #[test]
    fn albedos_are_the_means_of_the_models() {
        for model in MODELS {
            let mut worst = 0.0f64;
            for alpha in [0.003, 0.02, 0.08, 0.2, 0.4, 0.7, 1.0] {
                for c in [0.001, 0.02, 0.05, 0.1, 0.3, 0.6, 1.0] {
                    let (wo, albedo) = (direction(c, 0.0), DVec3::new(0.0, 0.4, 1.0));
                    let want = hemisphere(|wi| diffuse_value(model, wo, wi, alpha, albedo));
                    let got = diffuse_model_albedo(model, c, alpha, albedo);
                    worst = worst.max((want - got).abs().max_element());
                }
            }
            println!("{}: {worst:.2e}", model.name());
            let most = if model == DiffuseModel::CallOfDuty { 4e-3 } else { 2e-5 };
            assert!(worst < most, "{}: {worst}", model.name());
        }
    }

    /// The sum over all visible facets of a relief is near Lambert's sum times the value at the mean visible facet. At the mean normal
    /// instead, rough facets are up to ten times as far off. The facets of a normal map have equal weights.
    #[test]
    fn the_mean_visible_facet_stands_for_all_visible_facets() {
        let table = EnergyTable::beckmann();
        let azimuths = [0.0, 1.0, 2.0, PI];
        let cosines = [0.1, 0.3, 0.6, 0.9];
        let pairs: Vec<(DVec3, DVec3)> = cosines
            .into_iter()
            .flat_map(|o| cosines.map(|i| azimuths.map(|phi| (direction(o, 0.0), direction(i, phi)))))
            .flatten()
            .collect();
        for (model, mapped) in DiffuseModel::ALL[1..5].iter().flat_map(|&model| [(model, false), (model, true)]) {
            for (sigma, alpha) in [(0.2, 0.1), (0.2, 1.0), (0.5, 0.1), (0.5, 1.0)] {
                let (m, s) = (DVec2::ZERO, DVec3::new(sigma * sigma, sigma * sigma, 0.0));
                let cholesky = slope_cholesky(s);
                let squares = pairs.iter().map(|&(wo, wi)| {
                    let value = |slope: DVec2| {
                        let f = frame_about(normal_of_slope(slope));
                        let [o, i] = [wo, wi].map(|w| to_frame(&f, w)).map(|w| w.with_z(w.z.max(1e-3)));
                        grey_value(model, &table, o, i, alpha)
                    };
                    let (mut sum, mut lambert, mut area) = (0.0, 0.0, 0.0);
                    for node in grid_nodes(33, 4.0) {
                        let slope = slope_at(node.xy(), m, cholesky);
                        let area_of_facet = facet_area(wo, slope);
                        let seen = node.z * if mapped { f64::from(area_of_facet > 0.0) } else { area_of_facet };
                        let lit = seen * wi.dot(normal_of_slope(slope)).max(0.0);
                        sum += lit * value(slope);
                        lambert += lit;
                        area += seen;
                    }
                    let facet =
                        if mapped { mapped_slopes(wo, m, s, s).slopes.mean } else { visible_slopes(wo, m, s).mean };
                    [facet, m].map(|slope| ((lambert * value(slope) - sum) / area).powi(2))
                });
                let sums = squares.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
                let [visible, mean] = sums.map(|sum| (sum / pairs.len() as f64).sqrt());
                println!(
                    "{}, mapped {mapped}, σ {sigma}, α {alpha}: rms {visible:.4}, mean normal {mean:.4}",
                    model.name()
                );
                assert!(visible < 0.08 && (alpha < 1.0 || mean > 1.5 * visible), "{}: {visible} {mean}", model.name());
            }
        }
    }

    #[test]
    fn limits_and_reciprocity() {
        let (a, b) = (direction(0.3, 0.2), direction(0.9, 2.0));
        let grey = DVec3::new(0.1, 0.5, 0.9);
        for model in DiffuseModel::ALL {
            let [there, back] = [(a, b), (b, a)].map(|(o, i)| diffuse_value(model, o, i, 0.6, grey));
            assert!((there - back).abs().max_element() < 1e-12, "{there} {back}");
            for c in [f64::NAN, 0.0, 1.0] {
                assert!(diffuse_model_albedo(model, c, c, DVec3::ONE).is_finite());
            }
        }
        // Smooth facets are Lambertian, and rough ones flatter: brighter towards the light.
        assert_eq!(oren_nayar(a, b, 0.0, grey), DVec3::ONE);
        assert!(oren_nayar(a, a, 1.0, grey).x > oren_nayar(a, direction(0.3, 0.2 + PI), 1.0, grey).x);
    }
}
