//! Compares Beckmann and GGX, from isotropic to noncentral surfaces, with an existing BRDF library and with an independent evaluation of
//! the same equations (`crates/leadr-testing/data/brdf_values.json`).

use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ellipse::{Bivariate, ellipse_from_bivariate};
use leadr_reflectance::facets::ggx::{Ggx, ggx_masking_shadowing};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_testing::comparison::{Comparison, number, oracle, rows, vector};
use serde_json::Value;

/// Returns the mean slope and the roughness of a tuple.
fn parameters(c: &Value) -> (DVec2, Bivariate) {
    let alpha = DVec2::new(number(&c["alpha_x"]), number(&c["alpha_y"]));
    (DVec2::new(number(&c["tx_n"]), number(&c["ty_n"])), Bivariate::new(alpha, number(&c["rho"])))
}

fn is_beckmann(c: &Value) -> bool {
    c["family"] == "beckmann"
}

fn distribution(c: &Value) -> Box<dyn SlopeDistribution> {
    let (m, b) = parameters(c);
    if is_beckmann(c) { Box::new(Beckmann::from_bivariate(m, &b)) } else { Box::new(Ggx::from_bivariate(m, &b)) }
}

fn id(c: &Value) -> String {
    format!("tuple {} ({} {})", c["id"], c["family"].as_str().unwrap(), c["category"].as_str().unwrap())
}

#[test]
fn evaluations() {
    let data = oracle("brdf_values.json");
    let mut out = Comparison::default();
    for c in rows(&data["values"]) {
        let (d, id) = (distribution(c), id(c));
        let (wo, wi) = (vector(&c["o"]), vector(&c["i"]));
        let wh = (wo + wi).normalize();
        let g1 = |w: DVec3| if d.meso_area(w) > 0.0 { w.z / d.visible_area(w) } else { 0.0 };
        // The `erf` of the BRDF library has an error of 1.5e-7. All values without `erf` are exact.
        for source in ["dj", "ref"] {
            let v = &c[source];
            let mut check = |name, got: f64, key: &str| out.check(name, &id, got, number(&v[key]), 1e-6, 1e-100);
            check("p22", d.p22(-wh.xy() / wh.z), "p22");
            check("ndf", d.ndf(wh), "ndf");
            check("visible area o", d.visible_area(wo), "sigma_o");
            check("visible area i", d.visible_area(wi), "sigma_i");
            check("G1 o", g1(wo), "g1_o");
            check("G1 i", g1(wi), "g1_i");
            check("vndf", d.vndf(wo, wh), "vndf");
            check("masked BRDF", d.ndf(wh) / (4.0 * d.visible_area(wo)), "evalp_noshadow");
            // The BRDF library returns a density of 0 if the light is fully shadowed.
            if number(&v["pdf"]) != 0.0 {
                check("pdf", d.vndf(wo, wh) / (4.0 * wi.dot(wh)), "pdf");
            }
        }
        if !is_beckmann(c) && d.meso_area(wo) > 0.0 {
            let a = distribution_roughness(c);
            let got = d.ndf(wh) * ggx_masking_shadowing(wo, wi, d.mean_slope(), a, true) / 4.0;
            out.check("GGX, LEADR eq. 17", &id, got, number(&c["ref"]["leadr_eq17"]), 1e-6, 1e-100);
        }
    }
    out.finish(110 * 16);
}

fn distribution_roughness(c: &Value) -> DVec3 {
    let (m, b) = parameters(c);
    Ggx::from_bivariate(m, &b).roughness()
}

/// The ellipses of the BRDF library have the opposite angle sign, and their axes are swapped for ρ = 0 and α_y > α_x.
#[test]
fn ellipses() {
    let data = oracle("brdf_values.json");
    let mut out = Comparison::default();
    for c in rows(&data["values"]) {
        let e = ellipse_from_bivariate(&parameters(c).1);
        out.check("major radius", &id(c), e.radii.x, number(&c["dj"]["a1"]), 1e-7, 1e-100);
        out.check("minor radius", &id(c), e.radii.y, number(&c["dj"]["a2"]), 1e-7, 1e-100);
        if number(&c["rho"]) != 0.0 {
            out.check("angle", &id(c), -e.angle, number(&c["dj"]["phi_a"]), 1e-6, 1.0);
        }
    }
    out.finish(220);
}

/// Compares the reflected directions for the same pair of random numbers. The BRDF library clamps the pair to 1e-5..1 − 1e-5, and solves
/// for Beckmann samples to a probability error of 1e-5. For GGX it maps the square differently, so the test compares only the probability
/// of its samples. Its fit has an error of 4e-4.
#[test]
fn samples() {
    let data = oracle("brdf_values.json");
    let mut out = Comparison::default();
    for c in rows(&data["values"]) {
        let (d, id, wo) = (distribution(c), id(c), vector(&c["o"]));
        let u = DVec2::new(number(&c["u1"]), number(&c["u2"])) * 0.99998 + DVec2::splat(0.00001);
        let theirs = vector(&c["dj"]["sample_i"]);
        let wh = (wo + theirs).normalize();
        if is_beckmann(c) {
            let wn = d.sample_visible(wo, u);
            let ours = 2.0 * wo.dot(wn) * wn - wo;
            out.check("Beckmann sample", &id, (ours - theirs).length(), 0.0, 1e-3, 1.0);
        } else {
            let (m, b) = parameters(c);
            // The BRDF library's sample is a unit slope x along the viewer's azimuth, with the probability F(x) = (a (1 + x/r) + b/r) / 2A,
            // r = √(1 + x²).
            let factor = glam::DMat2::from_cols(
                DVec2::new(b.alpha.x, b.rho * b.alpha.y),
                DVec2::new(0.0, b.alpha.y * b.independence),
            );
            let slope = factor.inverse() * (-wh.xy() / wh.z - m);
            let t = factor.transpose() * wo.xy();
            let x = slope.dot(t.try_normalize().unwrap_or(DVec2::X));
            let (a, spread, r) = (d.meso_area(wo), t.length(), (1.0 + x * x).sqrt());
            let below = 0.5 * (a * (1.0 + x / r) + spread / r) / d.visible_area(wo);
            out.check("GGX sample", &id, below, 1.0 - u.x, 1e-3, 1.0);
        }
        if number(&c["dj"]["sample_pdf"]) != 0.0 {
            let pdf = d.vndf(wo, wh) / (4.0 * wo.dot(wh));
            out.check("pdf of the sample", &id, pdf, number(&c["dj"]["sample_pdf"]), 1e-6, 1e-100);
        }
    }
    out.finish(110 + 60);
}
