//! Compares the BRDFs with an existing BRDF library (`crates/leadr-testing/data/brdf_values.json`), for Beckmann and GGX, from isotropic to
//! noncentral surfaces.
//!
//! The library's shadowing of noncentral surfaces has the thesis's form, so it is compared with [`Masking::SmithThesis`] only. LEADR's
//! form is compared with the file's own evaluation of LEADR eq. 17.

use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::masking::variants::{Masking, geometric_attenuation, smith_g1};
use leadr_reflectance::materials::brdf::Brdf as _;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_testing::comparison::{Comparison, number, oracle, rows, vector};
use serde_json::Value;

/// The relative tolerance. The `erf` of the compared library has an error of 1.5e-7.
const TOLERANCE: f64 = 1e-6;

/// Compares one tuple of the file. `slopes` is the tuple's distribution, and `central` is the same distribution without the mean slope.
fn compare<D: SlopeDistribution + Copy>(out: &mut Comparison, c: &Value, slopes: D, central: D) {
    let id = format!("tuple {} ({} {})", c["id"], c["family"].as_str().unwrap(), c["category"].as_str().unwrap());
    let (wo, wi) = (vector(&c["o"]), vector(&c["i"]));
    let wh = (wo + wi).normalize();
    let is_central = slopes.mean_slope() == DVec2::ZERO;
    let brdf = |masking: Masking| Microfacet { distribution: slopes, masking, fresnel: Fresnel::Ideal };
    let g = |masking: Masking| geometric_attenuation(masking, &slopes, wo, wi, wh);
    for source in ["dj", "ref"] {
        let v = &c[source];
        let mut check = |name: &str, got: f64, key: &str| {
            let name = format!("{name} ({})", c["family"].as_str().unwrap());
            out.check(&name, &id, got, number(&v[key]), TOLERANCE, 1e-100);
        };
        check("p22", slopes.p22(-wh.xy() / wh.z), "p22");
        check("ndf", slopes.ndf(wh), "ndf");
        check("visible area", slopes.visible_area(wo), "sigma_o");
        check("visible area", slopes.visible_area(wi), "sigma_i");
        check("G1", smith_g1(&slopes, wo), "g1_o");
        check("G1", smith_g1(&slopes, wi), "g1_i");
        check("vndf", slopes.vndf(wo, wh), "vndf");
        // The compared library does not shade back-facing mesosurfaces, and clips directions at the macrosurface's horizon.
        let facing = slopes.meso_area(wo) > 0.0;
        if facing {
            check("masked G", g(Masking::SmithUnshadowed), "gaf_noshadow");
        }
        check("masked eval cos", brdf(Masking::SmithUnshadowed).eval_cos(wo, wi).x, "evalp_noshadow");
        if number(&v["gaf"]) > 0.0 {
            check("pdf", brdf(Masking::SmithCorrelated).pdf(wo, wi), "pdf");
        }
        check("thesis G", g(Masking::SmithThesis), "gaf");
        check("thesis eval cos", brdf(Masking::SmithThesis).eval_cos(wo, wi).x, "evalp");
        check("thesis eval", brdf(Masking::SmithThesis).eval(wo, wi).x, "eval");
        if is_central {
            check("G", g(Masking::SmithCorrelated), "gaf");
            check("eval cos", brdf(Masking::SmithCorrelated).eval_cos(wo, wi).x, "evalp");
            check("eval", brdf(Masking::SmithCorrelated).eval(wo, wi).x, "eval");
        }
        // The file has these values for central surfaces. They depend on the directions only.
        let g = |masking: Masking| geometric_attenuation(masking, &central, wo, wi, wh);
        check("V-groove G", g(Masking::VGroove), "gaf_vgroove");
        check("normal map G", g(Masking::NormalMap), "gaf_nmap");
        if source == "dj" {
            check("V-groove masked G", g(Masking::VGrooveUnshadowed), "gaf_vgroove_noshadow");
            check("normal map masked G", g(Masking::NormalMap), "gaf_nmap_noshadow");
        } else if facing && v["leadr_eq17"].is_number() {
            check("LEADR eq. 17", brdf(Masking::SmithCorrelated).eval_cos(wo, wi).x, "leadr_eq17");
            check("LEADR eq. 17, masking", brdf(Masking::SmithUnshadowed).eval_cos(wo, wi).x, "leadr_eq17_mask");
        }
    }
}

#[test]
fn library_values() {
    let data = oracle("brdf_values.json");
    let mut out = Comparison::default();
    for c in rows(&data["values"]) {
        let alpha = DVec2::new(number(&c["alpha_x"]), number(&c["alpha_y"]));
        let m = DVec2::new(number(&c["tx_n"]), number(&c["ty_n"]));
        let roughness = DVec3::new(alpha.x * alpha.x, alpha.y * alpha.y, number(&c["rho"]) * alpha.x * alpha.y);
        match c["family"].as_str() {
            Some("beckmann") => {
                let new = |m: DVec2| Beckmann::new(m, 0.5 * roughness);
                compare(&mut out, c, new(m), new(DVec2::ZERO));
            }
            Some("ggx") => {
                let new = |m: DVec2| Ggx::new(m, roughness);
                compare(&mut out, c, new(m), new(DVec2::ZERO));
            }
            family => panic!("family {family:?}"),
        }
    }
    out.finish(110 * 30 + 1);
}
