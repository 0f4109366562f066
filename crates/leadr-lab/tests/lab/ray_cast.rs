//! Compares the ray casts with another ray caster (`crates/leadr-testing/data`), with closed forms, and with another
//! resolution.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use leadr_lab::ray_cast::{Estimate, Patch, Spectrum, SphereTruth, Tile};
use leadr_reflectance::facets::projected_area::{meso_area, visible_area};
use leadr_reflectance::frame::{frame_about, from_frame, to_frame};
use leadr_reflectance::integrals::specular::leadr_specular_directional;
use leadr_reflectance::random::Random;
use leadr_testing::comparison::{number, oracle, rows, smooth};
use leadr_testing::sphere_oracle::{RADIUS, SIZE, SphereOracle, gradient, lobes, side_light};
use leadr_testing::standard::direction;
use serde_json::Value;

fn cosine_about(normal: DVec3, random: &mut Random) -> DVec3 {
    let (u, v) = (random.unit(), random.unit());
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    from_frame(&frame_about(normal), DVec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()))
}

#[test]
#[ignore = "long"]
fn patches_agree_with_another_ray_caster() {
    let data = oracle("patches.json");
    let mut all: BTreeMap<(&str, &str, bool), Vec<f64>> = BTreeMap::new();
    for (kind, spectrum) in [("gauss", Spectrum::Gaussian), ("ring", Spectrum::Ring)] {
        let tile = Tile::new(spectrum, 1024, 8.0, 1);
        for c in rows(&data[kind]) {
            let stats = rows(&c["stats"]);
            let mean = |f: &dyn Fn(&Value) -> f64| stats.iter().map(f).sum::<f64>() / stats.len() as f64;
            let variance = |name: &str| mean(&|v| number(&v[name]).powi(2));
            let s = DVec3::new(variance("sigma_x"), variance("sigma_y"), mean(&|v| number(&v["c_xy"])));
            let m = DVec2::new(number(&c["mean_x"]), number(&c["mean_y"]));
            let patch = Patch::new(&tile, m, s);
            let (theta, phi) = (number(&c["theta_o"]), number(&c["phi_o"]));
            let wo = direction(theta, phi);
            let wm = DVec3::new(-m.x, -m.y, 1.0).normalize();
            let mirror = 2.0 * wm.dot(wo) * wm - wo;
            let lobe = |d: DVec3| (10.0 * (d.dot(mirror) - 1.0)).exp();
            let n = 128;
            let got: [(&str, Option<Estimate<2>>); 7] = [
                ("diffuse_dir_front", patch.diffuse_light(wo, wo, n, 1)),
                ("diffuse_dir_side45", patch.diffuse_light(wo, direction(45.0, phi + 90.0), n, 2)),
                ("diffuse_dir_opp60", patch.diffuse_light(wo, direction(60.0, phi + 180.0), n, 3)),
                ("diffuse_env_const", patch.diffuse_environment(wo, n, 2, 4, |_| 1.0)),
                ("diffuse_env_smooth", patch.diffuse_environment(wo, n, 4, 5, smooth)),
                ("spec_env_const", patch.specular_environment(wo, n, 6, |_| 1.0)),
                ("spec_env_lobe10", patch.specular_environment(wo, n, 7, lobe)),
            ];
            // On steep surfaces both ray casters are noisy, and shadow rays of the other ray caster leak.
            let steep = s.x.max(s.y) > 2.0;
            for (name, estimate) in got {
                let estimate = estimate.expect("a surface that faces the viewer");
                for (k, key) in ["mask", "shadow"].into_iter().enumerate() {
                    let want = number(&c["measured"][name][key]);
                    let error = if want == 0.0 { estimate.mean[k].abs() } else { estimate.mean[k] / want - 1.0 };
                    all.entry((name, key, steep)).or_default().push(100.0 * error);
                }
            }
        }
    }
    let mut faults = String::new();
    for (&(name, key, steep), errors) in &all {
        let n = errors.len() as f64;
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        let (mean, largest) = (errors.iter().sum::<f64>() / n, errors.iter().fold(0.0f64, |a, e| a.max(e.abs())));
        // The bounds are in percent, and about 1.5 times the measured values.
        let bound = match (name, key, steep) {
            ("diffuse_env_const" | "spec_env_const", "mask", _) => 1e-9,
            ("diffuse_dir_front", _, false) => 0.3,
            ("diffuse_dir_side45" | "diffuse_env_smooth", "mask", false) => 0.4,
            ("diffuse_dir_opp60", "mask", false) => 1.1,
            ("diffuse_dir_opp60", ..) => 2.5,
            ("spec_env_lobe10", _, false) => 2.8,
            ("spec_env_lobe10", _, true) => 6.0,
            (_, _, true) => 2.5,
            _ => 1.4,
        };
        let steepness = if steep { ", σ = 2" } else { "" };
        let line = format!("{name} {key}{steepness}: rms {rms:.2} %, mean {mean:+.2} %, largest {largest:.2} %");
        println!("{line}");
        if rms > bound {
            faults += &format!("{line}, beyond {bound} %\n");
        }
    }
    assert_eq!(all.len(), 28);
    assert!(faults.is_empty(), "{faults}");
}

#[test]
fn spheres_agree_with_another_ray_caster() {
    for case in ["isotropic", "anisotropic"] {
        let sphere = SphereOracle::load(case);
        let tile = Tile::new(Spectrum::Gaussian, 1024, 8.0, 5);
        let patch = Patch::new(&tile, DVec2::ZERO, sphere.covariance);
        let truth = SphereTruth::cast(&patch, SIZE, RADIUS, 6, 1, |pixel, facet, random| {
            let light = |l: DVec3| {
                let wi = to_frame(&pixel.frame, l);
                let value = facet.normal.dot(wi).max(0.0) / std::f64::consts::PI;
                [value, if patch.is_lit(facet, wi) { value } else { 0.0 }]
            };
            let (front, side) = (light(DVec3::Z), light(side_light()));
            let wi = cosine_about(facet.normal, random);
            let diffuse = gradient(from_frame(&pixel.frame, wi));
            let wr = 2.0 * facet.normal.dot(pixel.wo) * facet.normal - pixel.wo;
            let mirror = lobes(from_frame(&pixel.frame, wr));
            let shadowed = |value: f64, wi: DVec3| if patch.is_lit(facet, wi) { value } else { 0.0 };
            [front[0], front[1], side[0], side[1], diffuse, shadowed(diffuse, wi), mirror, shadowed(mirror, wr)]
        });
        for (k, name) in ["diff_front", "diff_side", "diff_env", "spec_env"]
            .into_iter()
            .flat_map(|name| ["mask", "shadow"].map(|kind| format!("{name}_{kind}")))
            .enumerate()
        {
            let want = sphere.picture(&name);
            let e = truth.compare(k, |x, y, _| want.radiance[(y * SIZE + x) as usize]);
            let (mean, count) = want.mean();
            let theirs = want.noise / mean;
            // The mean square error without the noise of the other ray caster, and its standard error.
            let rest = e.rmse.powi(2).copysign(e.rmse) - theirs.powi(2);
            let error = 2.0 * (e.noise.powi(2) + theirs.powi(2)) / (count as f64).sqrt();
            println!(
                "{case} {name}: rms² less noise {:+.2e} (± {error:.1e}); bias {:+.2} %, rim {:+.2} %; noise {:.2} %, theirs {:.2} %",
                rest,
                100.0 * e.bias,
                100.0 * e.rim_bias,
                100.0 * e.noise,
                100.0 * theirs,
            );
            // Shadow rays of the other ray caster leak slightly.
            let (rms, bias) = if name.ends_with("mask") { (0.005, 0.004) } else { (0.015, 0.012) };
            assert!(rest < rms * rms + 3.0 * error, "{case} {name}: {rest:.1e} is more than {rms}²");
            assert!(e.bias.abs() < bias, "{case} {name}: bias {:+.2} %", 100.0 * e.bias);
        }
    }
}

/// The visible fraction of the area facing the viewer is exactly `a / A` on an infinite surface. Rays must not leak at any
/// angle.
#[test]
fn infinite_surface_shows_its_mean_area() {
    let tile = Tile::new(Spectrum::Gaussian, 512, 8.0, 2);
    let n = 300;
    for (m, s) in [
        (DVec2::ZERO, DVec3::new(0.0025, 0.0025, 0.0)),
        (DVec2::ZERO, DVec3::ONE.with_z(0.0)),
        (DVec2::new(0.5, -0.3), DVec3::new(0.04, 0.64, 0.08)),
    ] {
        let patch = Patch::new(&tile, m, s);
        for theta in [30.0, 60.0, 80.0, 85.0, 88.0] {
            let w = direction(theta, 200.0);
            let (a, area) = (meso_area(w, m), patch.facing_area(w));
            let closed = visible_area(w, m, s);
            // A tile of 64 correlation lengths is not exactly Gaussian.
            assert!((area / closed - 1.0).abs() < 0.01, "facing area {area}, of Gaussian slopes {closed}");
            let (seen, want) = (1.0 - patch.masked_fraction(w, n, 7), a / area);
            let error = ((1.0 - want).max(1e-6) / (want * f64::from(n * n))).sqrt();
            println!("{theta}°: {seen:.5} of the facing area is seen, {want:.5} by the projection (noise {error:.5})");
            assert!((seen / want - 1.0).abs() < 5.0 * error, "{theta}°, slopes {m} {s}: {seen} instead of {want}");
        }
    }
}

#[test]
fn slopes_from_above_are_those_prescribed() {
    let tile = Tile::new(Spectrum::Ring, 256, 6.0, 3);
    let (m, s) = (DVec2::new(0.3, -0.2), DVec3::new(0.3, 0.1, -0.12));
    let patch = Patch::new(&tile, m, s);
    let (mean, covariance) = patch.visible_slopes(DVec3::Z, 512, 1).unwrap();
    assert!((mean - m).length() < 0.002, "{mean}");
    assert!((covariance - s).abs().max_element() < 0.003, "{covariance}");
    // Seen from the side, slopes that face the viewer dominate. Correlated slopes also dominate.
    let (mean, _) = patch.visible_slopes(direction(60.0, 0.0), 256, 1).unwrap();
    assert!(mean.x < m.x - 0.1 && mean.y > m.y + 0.02, "{mean}");
    assert!(patch.visible_slopes(direction(80.0, 0.0), 16, 1).is_none(), "turned away");
}

/// The visible areas of all slopes add up to the visible area. The test relates casts per slope to the projected area.
#[test]
fn visibility_by_slope_sums_to_the_projection() {
    let tile = Tile::new(Spectrum::Gaussian, 512, 8.0, 4);
    let (m, s) = (DVec2::new(0.2, 0.1), DVec3::new(0.5, 0.5, 0.0));
    let patch = Patch::new(&tile, m, s);
    let (wo, wi) = (direction(70.0, 20.0), direction(50.0, 140.0));
    let step = 0.5;
    let (mut seen, mut lit, mut both) = (0.0, 0.0, 0.0);
    for (i, j) in (-7..=7).flat_map(|i| (-7..=7).map(move |j| (i, j))) {
        let u = DVec2::new(f64::from(i), f64::from(j)) * step;
        let slope = m + u * s.x.sqrt();
        let weight = (-0.5 * u.length_squared()).exp() / std::f64::consts::TAU * step * step;
        if let Some(v) = patch.visibility_of_slope(slope, 0.25, wo, wi, 800, 1) {
            seen += weight * meso_area(wo, slope).max(0.0) * v.seen;
            lit += weight * meso_area(wi, slope).max(0.0) * v.lit;
            both += weight * meso_area(wo, slope).max(0.0) * v.both;
        }
    }
    let rays = patch.mean_over_visible(wo, 128, 2, |f, _| [f64::from(patch.is_lit(f, wi))]).unwrap().mean[0];
    println!("seen {seen:.4} of {:.4}, lit {lit:.4} of {:.4}", meso_area(wo, m), meso_area(wi, m));
    println!("lit part of what is seen: {:.4} by slopes, {rays:.4} by rays", both / seen);
    assert!((seen / meso_area(wo, m) - 1.0).abs() < 0.03);
    assert!((lit / meso_area(wi, m) - 1.0).abs() < 0.03);
    assert!((both / seen / rays - 1.0).abs() < 0.03);
}

/// For specular facets seen from above under a high light, almost nothing is hidden. LEADR eq. 17 with masking only is then
/// exact.
#[test]
fn specular_from_above_is_the_slope_density() {
    let tile = Tile::new(Spectrum::Gaussian, 512, 8.0, 6);
    let s = DVec3::new(0.04, 0.02, 0.01);
    let patch = Patch::new(&tile, DVec2::ZERO, s);
    let (wo, wi) = (DVec3::Z, direction(25.0, 70.0));
    let [masked, shadowed] = patch.specular_light(wo, wi, 0.2, 2000, 1).unwrap();
    let want = leadr_specular_directional(wo, wi, DVec2::ZERO, s, DVec3::ONE, false).x;
    assert!((masked / want - 1.0).abs() < 1e-4 && (shadowed / want - 1.0).abs() < 0.01, "{masked} {shadowed} {want}");
}

/// Eight cells per correlation length suffice. Twice as many cells with the same statistics change the result little.
#[test]
fn the_lattice_resolves_the_relief() {
    let truth = |cells: f64, size: u32| {
        let mut sums = [0.0; 4];
        for seed in 0..3 {
            let tile = Tile::new(Spectrum::Gaussian, size, cells, seed);
            let patch = Patch::new(&tile, DVec2::ZERO, DVec3::ONE.with_z(0.0));
            let wo = direction(60.0, 30.0);
            let front = patch.diffuse_light(wo, wo, 200, seed).unwrap().mean[1];
            let opposite = patch.diffuse_light(wo, direction(60.0, 210.0), 200, seed).unwrap().mean[1];
            let sky = patch.diffuse_environment(wo, 200, 2, seed, |_| 1.0).unwrap().mean[1];
            let mirror = patch.specular_environment(wo, 200, seed, |_| 1.0).unwrap().mean[1];
            sums = std::array::from_fn(|k| sums[k] + [front, opposite, sky, mirror][k] / 3.0);
        }
        sums
    };
    let (four, eight, sixteen) = (truth(4.0, 256), truth(8.0, 512), truth(16.0, 1024));
    let bounds = [("front light", 1.0), ("opposite light", 5.0), ("diffuse sky", 1.0), ("mirrored sky", 3.0)];
    for (k, (name, bound)) in bounds.into_iter().enumerate() {
        let error = |v: f64| 100.0 * (v / sixteen[k] - 1.0);
        println!("{name}: {:.4}; with 8 cells {:+.2} %, with 4 {:+.2} %", sixteen[k], error(eight[k]), error(four[k]));
        assert!(error(eight[k]).abs() < bound, "{name}: {:+.2} %", error(eight[k]));
    }
}

/// The error of a wrong picture is measured correctly, even if it is below the noise.
#[test]
fn errors_of_spheres_are_measured_correctly() {
    let tile = Tile::new(Spectrum::Gaussian, 256, 8.0, 1);
    let patch = Patch::new(&tile, DVec2::ZERO, DVec3::new(0.25, 0.25, 0.0));
    let truth = SphereTruth::cast(&patch, 48, 0.95, 4, 1, |pixel, facet, _| [facet.normal.dot(pixel.wo)]);
    let better = SphereTruth::cast(&patch, 48, 0.95, 24, 2, |pixel, facet, _| [facet.normal.dot(pixel.wo)]);
    let right = truth.compare(0, |x, y, _| better.at(0, x, y).unwrap());
    let bright = truth.compare(0, |x, y, _| 1.03 * better.at(0, x, y).unwrap());
    println!("{right:?}\n{bright:?}");
    assert!(right.noise > 0.03 && right.rmse_with_noise > 0.03, "the pictures should be noisy");
    // With 1,600 pixels the mean square is uncertain by 2 · 0.068² / √1600, whose root is 0.015.
    assert!(right.rmse.abs() < 0.03 && right.bias.abs() < 0.005);
    assert!((bright.bias - right.bias - 0.03).abs() < 0.001);
    let added = bright.rmse * bright.rmse - right.rmse * right.rmse;
    assert!((added.sqrt() - 0.03).abs() < 0.003, "{added}");
}
