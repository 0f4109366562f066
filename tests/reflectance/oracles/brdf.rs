//! The BRDFs against the values of an existing BRDF library (`LEADR_SHARED/oracles/dj_brdf_values.json`): Beckmann and GGX,
//! isotropic to noncentral. Skipped, with a line that says so, where the data is absent.
//!
//! Its shadowing of noncentral surfaces is the thesis' form: held against [`Masking::SmithThesis`] alone. LEADR's is held
//! against the file's own evaluation of LEADR eq. 17.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr::reflectance::facets::beckmann::Beckmann;
use leadr::reflectance::facets::fresnel::Fresnel;
use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::facets::slope_distribution::SlopeDistribution;
use leadr::reflectance::masking::variants::{Masking, geometric_attenuation, smith_g1};
use leadr::reflectance::materials::brdf::Brdf as _;
use leadr::reflectance::materials::microfacet::Microfacet;
use serde_json::Value;

/// Worst error per name, and what is beyond 1e-6.
#[derive(Default)]
struct Comparison {
    worst: BTreeMap<String, (f64, usize)>,
    failures: String,
}

impl Comparison {
    fn check(&mut self, name: &str, id: &str, got: f64, want: f64) {
        // The library's erf is good to 1.5e-7.
        let error = (got - want).abs() / want.abs().max(1e-100);
        let worst = self.worst.entry(name.to_owned()).or_insert((0.0, 0));
        *worst = (if error > worst.0 || error.is_nan() { error } else { worst.0 }, worst.1 + 1);
        if error > 1e-6 || error.is_nan() {
            writeln!(self.failures, "{name} of {id}: {got:.9e} instead of {want:.9e} ({error:.1e})").unwrap();
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

/// `slopes` as the tuple has it, `central` without its mean.
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
            out.check(&format!("{name} ({})", c["family"].as_str().unwrap()), &id, got, number(&v[key]));
        };
        check("p22", slopes.p22(-wh.xy() / wh.z), "p22");
        check("ndf", slopes.ndf(wh), "ndf");
        check("visible area", slopes.visible_area(wo), "sigma_o");
        check("visible area", slopes.visible_area(wi), "sigma_i");
        check("G1", smith_g1(&slopes, wo), "g1_o");
        check("G1", smith_g1(&slopes, wi), "g1_i");
        check("vndf", slopes.vndf(wo, wh), "vndf");
        // The library shades no mesosurface that faces away, and counts from the macrosurface's horizon.
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
        // Given for central surfaces; they depend on directions alone.
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
    let Some(root) = std::env::var_os("LEADR_SHARED") else {
        println!("skipped: LEADR_SHARED is not set, so oracles/dj_brdf_values.json cannot be found");
        return;
    };
    let path = PathBuf::from(root).join("oracles/dj_brdf_values.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let data: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut out = Comparison::default();
    for c in data["values"].as_array().unwrap() {
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
    for (name, (error, count)) in &out.worst {
        println!("{name:<32} {count:>4} values, worst error {error:.1e}");
    }
    let count: usize = out.worst.values().map(|w| w.1).sum();
    assert!(count > 110 * 30, "only {count} comparisons");
    assert!(out.failures.is_empty(), "{}", out.failures);
}

/// The comparison must notice one part in a hundred thousand, a NaN and a sign.
#[test]
fn the_comparison_fails_when_it_should() {
    for (got, want) in [(1.000_01, 1.0), (f64::NAN, 1.0), (-1.0, 1.0), (0.0, 1e-30), (1e-30, 0.0)] {
        let mut out = Comparison::default();
        out.check("a", "b", got, want);
        assert!(!out.failures.is_empty(), "{got} passed for {want}");
    }
    let mut out = Comparison::default();
    out.check("a", "b", 1.000_000_1, 1.0);
    assert!(out.failures.is_empty());
}
