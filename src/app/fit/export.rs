//! The nearest materials of other renderers: one GGX lobe, of a metal or above a diffuse body, whichever is nearer to what was measured.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use crate::reflectance::extraction::samples::{Misfit, Sample, misfit};
use crate::reflectance::facets::ellipse::{Ellipse, roughness_from_ellipse};
use crate::reflectance::facets::fresnel::{Fresnel, fresnel_dielectric, schlick_weight};
use crate::reflectance::facets::ggx::Ggx;
use crate::reflectance::masking::variants::Masking;
use crate::reflectance::materials::brdf::Brdf;
use crate::reflectance::materials::microfacet::{Microfacet, microfacet_eval};

/// Refractive index of the coats that are written: of most plastics and varnishes.
const COAT_INDEX: f64 = 1.5;

/// A material of one GGX lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simple {
    /// Half-axes of `α`, and the angle of the first.
    ellipse: Ellipse,
    surface: Surface,
}

/// What the lobe lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    /// Nothing: a metal of this reflectance at normal incidence.
    Metal(DVec3),
    /// A body of this albedo under a dielectric.
    Coated(DVec3),
}

/// Whether a direction of an ellipse means nothing.
pub fn is_round(ellipse: &Ellipse) -> bool {
    (ellipse.radii.x - ellipse.radii.y).abs() < 1e-6 * ellipse.radii.x
}

/// A simple material as it reflects.
struct Reflecting {
    facets: Microfacet<Ggx>,
    body: DVec3,
}

impl Brdf for Reflecting {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.body * (FRAC_1_PI * wi.z.max(0.0)) + self.facets.eval_cos(wo, wi)
    }
}

impl Simple {
    /// The nearer of a metal and a coated body with a lobe of this roughness, and how far it is from the samples.
    pub fn nearest(samples: &[Sample], ellipse: Ellipse) -> (Self, Misfit) {
        let slopes = Ggx::new(DVec2::ZERO, roughness_from_ellipse(&ellipse));
        let ideal = |s: &Sample| microfacet_eval(Masking::SmithCorrelated, &slopes, s.wo, s.wi) / s.wi.z;
        // Least squares, each with the one colour that it has.
        let (mut of_metal, mut of_body) = ((DVec3::ZERO, 0.0), (DVec3::ZERO, 0.0));
        for s in samples {
            let (ideal, cosine) = (ideal(s), s.wo.dot(s.wh));
            // Schlick's F = F₀ rest + (1 − rest).
            let rest = 1.0 - schlick_weight(cosine);
            of_metal.0 += s.weight * ideal * rest * (s.value - DVec3::splat(ideal * (1.0 - rest)));
            of_metal.1 += s.weight * (ideal * rest) * (ideal * rest);
            of_body.0 += s.weight * (s.value - DVec3::splat(ideal * fresnel_dielectric(cosine, COAT_INDEX)));
            of_body.1 += s.weight;
        }
        let f0 = (of_metal.0 / of_metal.1.max(1e-12)).clamp(DVec3::splat(0.001), DVec3::splat(0.999));
        let albedo = (PI * of_body.0 / of_body.1.max(1e-12)).clamp(DVec3::ZERO, DVec3::splat(0.999));
        [Surface::Metal(f0), Surface::Coated(albedo)]
            .map(|surface| {
                let (fresnel, body) = match surface {
                    Surface::Metal(f0) => (Fresnel::Schlick(f0), DVec3::ZERO),
                    Surface::Coated(albedo) => (Fresnel::Dielectric(COAT_INDEX), albedo),
                };
                let facets = Microfacet { distribution: slopes, masking: Masking::SmithCorrelated, fresnel };
                (Self { ellipse, surface }, misfit(samples, &Reflecting { facets, body }))
            })
            .into_iter()
            .min_by(|(_, a), (_, b)| a.perceptual.total_cmp(&b.perceptual))
            .expect("there are two")
    }

    /// A BSDF of Mitsuba 3. A conductor of index `(1 + √F₀)/(1 − √F₀)` has this F₀.
    pub fn mitsuba(&self, name: &str) -> String {
        let Ellipse { radii, angle } = self.ellipse;
        let rgb = |c: [f64; 3]| format!("{:.6}, {:.6}, {:.6}", c[0], c[1], c[2]);
        match self.surface {
            Surface::Coated(albedo) => format!(
                "<bsdf version=\"3.0.0\" type=\"roughplastic\" id=\"{name}\">\n    <string name=\"distribution\" value=\"ggx\"/>\n    \
                 <float name=\"alpha\" value=\"{:.6}\"/>\n    <float name=\"int_ior\" value=\"{COAT_INDEX}\"/>\n    \
                 <rgb name=\"diffuse_reflectance\" value=\"{}\"/>\n</bsdf>\n",
                (radii.x * radii.y).sqrt(),
                rgb(albedo.to_array())
            ),
            Surface::Metal(f0) => format!(
                "{}<bsdf version=\"3.0.0\" type=\"roughconductor\" id=\"{name}\">\n    <string name=\"distribution\" value=\"ggx\"/>\n    \
                 <float name=\"alpha_u\" value=\"{:.6}\"/>\n    <float name=\"alpha_v\" value=\"{:.6}\"/>\n    \
                 <rgb name=\"eta\" value=\"{}\"/>\n    <rgb name=\"k\" value=\"0, 0, 0\"/>\n</bsdf>\n",
                self.turned(
                    |degrees| format!("<!-- alpha_u is turned by {degrees:.2} degrees from the tangent -->\n"),
                    angle
                ),
                radii.x,
                radii.y,
                rgb(f0.to_array().map(|f| (1.0 + f.sqrt()) / (1.0 - f.sqrt())))
            ),
        }
    }

    /// A named material of pbrt-v4.
    pub fn pbrt(&self, name: &str) -> String {
        let Ellipse { radii, angle } = self.ellipse;
        let rgb = |c: DVec3| format!("{:.6} {:.6} {:.6}", c.x, c.y, c.z);
        let head = format!("MakeNamedMaterial \"{name}\"");
        match self.surface {
            Surface::Coated(albedo) => format!(
                "{head} \"string type\" \"coateddiffuse\" \"rgb reflectance\" [ {} ]\n    \"float eta\" {COAT_INDEX} \"float roughness\" {:.6} \
                 \"bool remaproughness\" false\n",
                rgb(albedo),
                (radii.x * radii.y).sqrt()
            ),
            Surface::Metal(f0) => format!(
                "{}{head} \"string type\" \"conductor\" \"rgb reflectance\" [ {} ]\n    \"float uroughness\" {:.6} \"float vroughness\" {:.6} \
                 \"bool remaproughness\" false\n",
                self.turned(
                    |degrees| format!("# uroughness is turned by {degrees:.2} degrees from the tangent\n"),
                    angle
                ),
                rgb(f0),
                radii.x,
                radii.y
            ),
        }
    }

    /// A remark on the lobe's direction, if it has one.
    fn turned(&self, remark: impl Fn(f64) -> String, angle: f64) -> String {
        if is_round(&self.ellipse) { String::new() } else { remark(angle.to_degrees()) }
    }
}

/// A name that both accept, from that of a file.
#[must_use]
pub fn identifier(stem: &str) -> String {
    let mut name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(60).collect();
    if name.is_empty() {
        name.push_str("material");
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflectance::extraction::samples::samples;

    fn ellipse(x: f64, y: f64) -> Ellipse {
        Ellipse { radii: DVec2::new(x, y), angle: if x == y { 0.0 } else { 0.5 } }
    }

    fn reflecting(ellipse: Ellipse, fresnel: Fresnel, body: DVec3) -> Reflecting {
        let distribution = Ggx::new(DVec2::ZERO, roughness_from_ellipse(&ellipse));
        Reflecting { facets: Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel }, body }
    }

    #[test]
    fn a_metal_is_written_as_a_metal() {
        let long = ellipse(0.3, 0.1);
        let gold = reflecting(long, Fresnel::Schlick(DVec3::new(0.9, 0.7, 0.4)), DVec3::ZERO);
        let (found, wrong) = Simple::nearest(&samples(&gold, false), long);
        let Surface::Metal(f0) = found.surface else { panic!("{found:?}") };
        assert!((f0 - DVec3::new(0.9, 0.7, 0.4)).length() < 0.02 && wrong.perceptual < 0.02, "{f0} {wrong:?}");
        let (mitsuba, pbrt) = (found.mitsuba("gold"), found.pbrt("gold"));
        assert!(mitsuba.contains("roughconductor") && mitsuba.contains("\"alpha_v\" value=\"0.100000\""), "{mitsuba}");
        assert!(pbrt.contains("\"conductor\" \"rgb reflectance\" [ 0.9") && pbrt.contains("28.65 degrees"), "{pbrt}");
    }

    #[test]
    fn a_varnish_is_written_as_a_coat() {
        let round = ellipse(0.2, 0.2);
        let paint = reflecting(round, Fresnel::Dielectric(1.5), DVec3::new(0.5, 0.2, 0.1));
        let (found, wrong) = Simple::nearest(&samples(&paint, true), round);
        let Surface::Coated(albedo) = found.surface else { panic!("{found:?}") };
        assert!((albedo - DVec3::new(0.5, 0.2, 0.1)).length() < 1e-3 && wrong.rrmse < 1e-3, "{albedo} {wrong:?}");
        let (mitsuba, pbrt) = (found.mitsuba("paint"), found.pbrt("paint"));
        assert!(mitsuba.contains("roughplastic") && mitsuba.contains("\"alpha\" value=\"0.200000\""), "{mitsuba}");
        assert!(pbrt.contains("coateddiffuse") && !pbrt.contains("turned"), "{pbrt}");
        assert_eq!(identifier("a b/\"c\""), "a_b__c_");
        assert_eq!(identifier(""), "material");
    }
}
