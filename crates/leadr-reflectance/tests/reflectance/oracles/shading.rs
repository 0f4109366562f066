//! Compares the 64-bit reference with external values (`crates/leadr-testing/data`). The values come from an independent dense quadrature
//! of LEADR's equations, the oracle, and from an existing BRDF library.

use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::beckmann::{beckmann_ndf, beckmann_p22};
use leadr_reflectance::facets::projected_area::{meso_area, visible_area};
use leadr_reflectance::integrals::diffuse::{leadr_diffuse_light, leadr_diffuse_light_sh, visible_normal_moments};
use leadr_reflectance::integrals::reference::{diffuse_directional, specular_environment, visible_mean};
use leadr_reflectance::integrals::sh::{Sh9, sh_add_light, sh_irradiance};
use leadr_reflectance::integrals::specular::{
    EnvironmentSample, leadr_specular_directional, leadr_specular_environment,
};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::masking::smith::{masking, masking_shadowing, smith_lambda};
use leadr_reflectance::slopes::grid::{facet_area, grid_node, normal_of_slope, slope_sample};
use leadr_testing::comparison::{Comparison, number, oracle, rows, smooth, vector};
use rayon::prelude::*;
use serde_json::Value;

fn statistics(c: &Value) -> (DVec2, DVec3) {
    let (sx, sy) = (number(&c["sigma_x"]), number(&c["sigma_y"]));
    (DVec2::new(number(&c["mean_x"]), number(&c["mean_y"])), DVec3::new(sx * sx, sy * sy, number(&c["c_xy"])))
}

/// A function from a direction in the tangent frame to a radiance.
type Environment<'a> = Box<dyn Fn(DVec3) -> f64 + 'a>;

/// Returns the sum of the grid's weights divided by the exact visible area. As in the paper's Algorithm 3, the oracle's grids with
/// shadowing do not divide by this sum. Its grids with masking only divide by the sum, as in the supplement.
fn sum_over_area(wo: DVec3, m: DVec2, s: DVec3, n: u32, lambda: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for j in 0..n {
        for k in 0..n {
            let node = grid_node(j, k, n, lambda);
            sum += node.z * facet_area(wo, slope_sample(node.xy(), m, s));
            weights += node.z;
        }
    }
    sum / weights / visible_area(wo, m, s)
}

#[test]
#[ignore = "long"]
fn converged_integrals() {
    let data = oracle("leadr_integrals.json");
    let sh: Vec<f64> = rows(&data["sh_smooth"]).iter().map(number).collect();
    let sh: Sh9 = std::array::from_fn(|i| DVec3::splat(sh[i]));
    let all = rows(&data["configs"]).par_iter().map(|c| {
        let mut out = Comparison::default();
        let id = format!("configuration {}", c["id"]);
        let (m, s) = statistics(c);
        let (wo, light, lobe) = (vector(&c["o"]), vector(&c["light"]), vector(&c["lobe_dir"]));
        out.check("mesosurface area", &id, meso_area(wo, m), number(&c["c_o"]), 1e-12, 1e-3);
        out.check("visible area", &id, visible_area(wo, m, s), number(&c["sigma_o_projected_area"]), 1e-10, 1e-300);
        for (key, w) in [("Lambda_o", wo), ("Lambda_i", light)] {
            match c[key].as_f64() {
                // Below 1e-12 the oracle loses its digits to cancellation.
                Some(lambda) => out.check("Λ", &id, smith_lambda(w, m, s), lambda, 1e-9, 1e-6),
                None => assert!(meso_area(w, m) <= 0.0, "{id}"),
            }
        }
        let environments: [(&str, Environment<'_>); 5] = [
            ("const", Box::new(|_| 1.0)),
            ("smooth", Box::new(smooth)),
            ("lobe30_fixed", Box::new(|d| (30.0 * (d.dot(DVec3::new(0.5, 0.3, 0.8).normalize()) - 1.0)).exp())),
            ("lobe10", Box::new(|d| (10.0 * (d.dot(lobe) - 1.0)).exp())),
            ("lobe100", Box::new(|d| (100.0 * (d.dot(lobe) - 1.0)).exp())),
        ];
        // The panels have 8×8 nodes. Wide slopes need more panels, because narrow lobes and the shadow edge lie anywhere in the domain.
        let panels = if s.x.max(s.y) > 0.8 { 200 } else { 64 };
        for (key, shadowing) in [("shadow", true), ("mask", false)] {
            // A single pass over the slopes integrates three environments.
            for group in environments.chunks(3) {
                let radiance =
                    |d: DVec3| DVec3::from_array(std::array::from_fn(|i| group.get(i).map_or(0.0, |g| (g.1)(d))));
                let i = specular_environment(wo, m, s, shadowing, panels, radiance);
                for (lane, (name, _)) in group.iter().enumerate() {
                    out.check(
                        "specular environment",
                        &format!("{id} {name} {key}"),
                        i[lane],
                        number(&c["specular_env"][name][key]),
                        1e-4,
                        1e-6,
                    );
                }
            }
            for name in ["light", "near_mirror"] {
                let o = &c["specular_directional"][name];
                let wi = vector(&o["dir"]);
                let i = leadr_specular_directional(wo, wi, m, s, DVec3::ONE, shadowing).x;
                out.check("specular directional", &format!("{id} {name} {key}"), i, number(&o[key]), 1e-9, 1e-100);
                out.check("D", &id, beckmann_ndf((wo + wi).normalize(), m, s), number(&o["D_h"]), 1e-9, 1e-100);
            }
            let i = diffuse_directional(wo, light, m, s, shadowing, 12);
            out.check(
                "diffuse directional",
                &format!("{id} {key}"),
                i,
                number(&c["diffuse_directional"][key]),
                1e-6,
                1e-6,
            );
            let mut one = [DVec3::ZERO; 9];
            sh_add_light(&mut one, light, DVec3::ONE);
            let e = visible_mean(wo, m, s, 24, |slope| sh_irradiance(&one, normal_of_slope(slope))).x;
            let factor = masking_shadowing(wo, light, m, s, shadowing) * visible_area(wo, m, s);
            let want = number(&c["diffuse_sh"][&format!("dirlight_{key}")]);
            // The oracle uses the paper's six-digit constants.
            out.check("diffuse SH light", &format!("{id} {key}"), e * factor / std::f64::consts::PI, want, 1e-5, 3e-2);
        }
        let e = visible_mean(wo, m, s, 24, |slope| sh_irradiance(&sh, normal_of_slope(slope))).x;
        out.check(
            "diffuse SH environment",
            &id,
            e / std::f64::consts::PI,
            number(&c["diffuse_sh"]["smooth_mask"]),
            1e-5,
            1e-2,
        );
        out
    });
    all.reduce(Comparison::default, Comparison::merge).finish(57 * 25);
}

#[test]
fn grids_of_the_paper() {
    let data = oracle("leadr_integrals.json");
    let mut out = Comparison::default();
    for c in rows(&data["configs"]) {
        let (m, s) = statistics(c);
        let (wo, light, lobe) = (vector(&c["o"]), vector(&c["light"]), vector(&c["lobe_dir"]));
        // The oracle does not tilt mesosurfaces, so tilted mesosurfaces cannot be compared.
        if meso_area(wo, m) < 1e-3 {
            continue;
        }
        for (n, lambda) in [(3, 1.2), (5, 1.8), (7, 2.4), (32, 3.0)] {
            let grid = &c["paper_grids"][n.to_string()];
            let id = format!("configuration {} N = {n}", c["id"]);
            let specular = |f: &dyn Fn(DVec3) -> f64| {
                let lookup = |e: &EnvironmentSample| DVec3::splat(f(e.wi));
                leadr_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, n, lambda, lookup).reflected.x
            };
            out.check("grid smooth", &id, specular(&smooth), number(&grid["s_smooth_pt"]), 1e-9, 1e-9);
            let lobe10 = specular(&|d: DVec3| (10.0 * (d.dot(lobe) - 1.0)).exp());
            out.check("grid lobe 10", &id, lobe10, number(&grid["s_lobe10_pt"]), 1e-8, 1e-12);
            let lobe100 = specular(&|d: DVec3| (100.0 * (d.dot(lobe) - 1.0)).exp());
            out.check("grid lobe 100", &id, lobe100, number(&grid["s_lobe100_pt"]), 1e-8, 1e-12);
            let ratio = sum_over_area(wo, m, s, n, lambda);
            let i = leadr_diffuse_light(wo, light, m, s, false, n, lambda);
            out.check("grid diffuse light, masking", &id, i, number(&grid["d_dir_mask"]), 1e-9, 1e-9);
            let i = leadr_diffuse_light(wo, light, m, s, true, n, lambda) * ratio;
            out.check("grid diffuse light, shadowing", &id, i, number(&grid["d_dir_shadow"]), 1e-9, 1e-9);
            let v = visible_normal_moments(wo, m, s, n, lambda);
            let i = leadr_diffuse_light_sh(&v, wo, light, m, s, false);
            // This library clamps the radiance at 0.
            let want = number(&grid["d_shdir_mask"]).max(0.0);
            out.check("grid diffuse SH light", &id, i, want, 1e-5, 3e-2);
        }
    }
    out.finish(57 * 4 * 5);
}

#[test]
fn library_values() {
    let data = oracle("brdf_values.json");
    let mut out = Comparison::default();
    for c in rows(&data["values"]) {
        if c["family"] != "beckmann" {
            continue;
        }
        let id = format!("tuple {} ({})", c["id"], c["category"].as_str().unwrap());
        let (sx, sy) = (number(&c["sigma_x"]), number(&c["sigma_y"]));
        let m = DVec2::new(number(&c["tx_n"]), number(&c["ty_n"]));
        let s = DVec3::new(sx * sx, sy * sy, number(&c["c_xy"]));
        let (wo, wi) = (vector(&c["o"]), vector(&c["i"]));
        let wh = (wo + wi).normalize();
        let d = beckmann_ndf(wh, m, s);
        let (area_o, area_i) = (visible_area(wo, m, s), visible_area(wi, m, s));
        let g1 = |w: DVec3, area: f64| if meso_area(w, m) > 0.0 { w.z / area } else { 0.0 };
        // The `erf` of the BRDF library has an error of 1.5e-7. Its densities are exact.
        for source in ["dj", "ref"] {
            let v = &c[source];
            let mut check = |name, got: f64, key: &str| out.check(name, &id, got, number(&v[key]), 1e-6, 1e-100);
            check("p22", beckmann_p22(-wh.xy() / wh.z, m, s), "p22");
            check("ndf", d, "ndf");
            check("visible area o", area_o, "sigma_o");
            check("visible area i", area_i, "sigma_i");
            check("G1 o", g1(wo, area_o), "g1_o");
            check("G1 i", g1(wi, area_i), "g1_i");
            check("vndf", wo.dot(wh).max(0.0) * d * masking(wo, m, s), "vndf");
            check("masked BRDF", leadr_specular_directional(wo, wi, m, s, DVec3::ONE, false).x, "evalp_noshadow");
            let central = m == DVec2::ZERO;
            let shadowed = leadr_specular_directional(wo, wi, m, s, DVec3::ONE, true).x;
            if central {
                check("shadowed BRDF, central", shadowed, "evalp");
            }
            if source == "ref" && meso_area(wo, m) > 0.0 {
                check("LEADR eq. 17", shadowed, "leadr_eq17");
                check(
                    "LEADR eq. 17, masking",
                    leadr_specular_directional(wo, wi, m, s, DVec3::ONE, false).x,
                    "leadr_eq17_mask",
                );
            }
        }
    }
    out.finish(55 * 16);
}

/// The comparison must reject errors beyond its tolerance, NaN and a wrong sign.
#[test]
fn the_comparison_fails_when_it_should() {
    let passes = |got, want, tolerance, floor| {
        let mut out = Comparison::default();
        out.check("a", "b", got, want, tolerance, floor);
        out.failures.is_empty()
    };
    for (got, want) in [(1.01, 1.0), (f64::NAN, 1.0), (-1.0, 1.0), (0.0, 1e-5)] {
        assert!(!passes(got, want, 1e-4, 1e-6), "{got} passed for {want}");
    }
    assert!(passes(1.000_01, 1.0, 1e-4, 1e-6));
    for (got, want) in [(1.000_01, 1.0), (f64::NAN, 1.0), (-1.0, 1.0), (0.0, 1e-30), (1e-30, 0.0)] {
        assert!(!passes(got, want, 1e-6, 1e-100), "{got} passed for {want}");
    }
    assert!(passes(1.000_000_1, 1.0, 1e-6, 1e-100));
}
