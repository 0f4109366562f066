//! Chi-square tests of the samplers of visible normals, in f64 and on the device. Samples are counted in bins of the visible
//! slopes. Expected counts are integrals of the density of visible normals over each bin. The total significance is 1 %,
//! divided by the number of tests.

use crate::chi_square::p_value;
use glam::{DVec2, DVec3};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::quadrature::gauss_legendre;
use leadr_reflectance::random::{STEP, mix, unit_of_bits};
use leadr_testing::gpu::{run_probe, test_gpu};
use leadr_testing::standard::{Seen, direction, surfaces};
use rayon::prelude::*;

/// Bins per axis.
const BINS: usize = 16;
/// Samples per test.
const SAMPLES: usize = 40_000;
/// Probability that any test of one function fails for a correct sampler.
const SIGNIFICANCE: f64 = 0.01;

/// Integrals of the density of visible normals over the bins. `density` is a parameter so that wrong densities can be tried.
fn expected(seen: &Seen<'_>, density: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let rule = gauss_legendre(10);
    let half = 0.5 / BINS as f64;
    let mut bins = vec![0.0; BINS * BINS];
    for (index, bin) in bins.iter_mut().enumerate() {
        let middle = DVec2::new((index % BINS) as f64 + 0.5, (index / BINS) as f64 + 0.5) / BINS as f64;
        for &(u, wu) in &rule {
            for &(v, wv) in &rule {
                let (p, area) = seen.from_square(middle + half * DVec2::new(u, v));
                let (wn, solid_angle) = seen.normal(p);
                *bin += half * half * wu * wv * area * solid_angle * density(wn);
            }
        }
    }
    bins
}

fn histogram(seen: &Seen<'_>, normals: impl Iterator<Item = DVec3>) -> Vec<f64> {
    let mut bins = vec![0.0; BINS * BINS];
    for wn in normals {
        let q = seen.square_of(seen.coordinates(wn)) * BINS as f64;
        bins[q.y as usize * BINS + q.x as usize] += 1.0;
    }
    bins
}

/// A pseudo-random pair. A lattice would hide errors of the samplers.
fn random_pair(i: u64) -> DVec2 {
    let unit = |counter: u64| unit_of_bits(mix(counter.wrapping_mul(STEP)));
    DVec2::new(unit(2 * i + 1), unit(2 * i + 2))
}

fn p_of(seen: &Seen<'_>, normals: impl Iterator<Item = DVec3>, density: impl Fn(DVec3) -> f64) -> f64 {
    let observed = histogram(seen, normals);
    let total: f64 = observed.iter().sum();
    let wanted: Vec<f64> = expected(seen, density).iter().map(|e| e * total).collect();
    p_value(&observed, &wanted)
}

fn samples(d: &dyn SlopeDistribution, wo: DVec3, seed: u64) -> impl Iterator<Item = DVec3> {
    (0..SAMPLES as u64).map(move |i| d.sample_visible(wo, random_pair(i + (seed << 32))))
}

/// Surfaces and viewers: from straight above to beyond the mesosurface's horizon.
fn cases() -> Vec<(DVec2, DVec3, DVec3)> {
    let angles = [0.0, 50.0, 80.0, 89.0, 120.0];
    surfaces()
        .into_iter()
        .enumerate()
        .flat_map(|(i, (m, s))| {
            // Two viewers for each surface.
            [0, 2].map(|k| (m, s, direction(angles[(i + k) % angles.len()], 25.0 + 77.0 * i as f64)))
        })
        .collect()
}

fn check(name: &str, p: &[(f64, String)]) {
    let (lowest, at) = p.iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are cases");
    let below_a_tenth = p.iter().filter(|(p, _)| *p < 0.1).count();
    println!("{name}: {} tests, lowest p {lowest:.1e} at {at}; {below_a_tenth} below 0.1", p.len());
    assert!(*lowest > SIGNIFICANCE / p.len() as f64, "{name} at {at}: p = {lowest:e}");
    // p-values must be uniform: a tenth of them lies below 0.1. If all were near one, the test would be too lenient.
    assert!(below_a_tenth > p.len() / 40 && below_a_tenth < p.len() / 4, "{name}: {below_a_tenth} of {}", p.len());
}

#[test]
fn beckmann_sampler_follows_its_density() {
    let p: Vec<_> = cases()
        .into_par_iter()
        .enumerate()
        .filter_map(|(i, (m, s, wo))| {
            let d = Beckmann::new(m, s);
            let seen = Seen::beckmann(&d, wo);
            // Beyond this, nothing is visible.
            (seen.nu > -10.0).then(|| {
                let p = p_of(&seen, samples(&d, wo, i as u64), |n| d.vndf(wo, n));
                (p, format!("ν {:.2}, {d:?}, wo {wo}", seen.nu))
            })
        })
        .collect();
    assert!(p.len() > 50);
    check("Beckmann", &p);
}

#[test]
fn ggx_sampler_follows_its_density() {
    let p: Vec<_> = cases()
        .into_par_iter()
        .enumerate()
        .map(|(i, (m, s, wo))| {
            let d = Ggx::new(m, s);
            let seen = Seen::ggx(&d, wo);
            let p = p_of(&seen, samples(&d, wo, 1000 + i as u64), |n| d.vndf(wo, n));
            (p, format!("ν {:.2}, {d:?}, wo {wo}", seen.nu))
        })
        .collect();
    check("GGX", &p);
}

/// The device's samplers, 32 bits, against the f64 density.
#[test]
fn device_samplers_follow_their_densities() {
    let Some(gpu) = test_gpu() else { return };
    let cases: Vec<_> = cases().into_iter().step_by(3).collect();
    let run = |ggx: bool| -> Vec<(f64, String)> {
        let one = |(i, &(m, s, wo)): (usize, &(DVec2, DVec3, DVec3))| {
            let (beckmann, broad) = (Beckmann::new(m, s), Ggx::new(m, s));
            let seen = if ggx { Seen::ggx(&broad, wo) } else { Seen::beckmann(&beckmann, wo) };
            // With a correlation of 1 or the least variance, 32 bits cannot resolve a histogram of the narrow axis.
            if s.z.abs() > 0.999 * (s.x * s.y).sqrt() || s.x < 1e-6 || seen.nu < -10.0 {
                return None;
            }
            let pairs: Vec<DVec2> = (0..SAMPLES as u64).map(|k| random_pair(k + ((5000 + i as u64) << 32))).collect();
            let arguments = |u: DVec2| [wo.x, wo.y, wo.z, u.x, u.y, m.x, m.y, s.x, s.y, s.z, 0.0].map(|v| v as f32);
            let (shader, outputs) =
                if ggx { ("probes/facets/ggx_sampling.comp", 3) } else { ("probes/facets/beckmann_sampling.comp", 5) };
            let got = if ggx {
                let inputs: Vec<[f32; 10]> = pairs.iter().map(|&u| std::array::from_fn(|k| arguments(u)[k])).collect();
                run_probe(&gpu, shader, &inputs, outputs)
            } else {
                let inputs: Vec<_> = pairs.iter().map(|&u| arguments(u)).collect();
                run_probe(&gpu, shader, &inputs, outputs)
            };
            let normals = got.chunks(outputs).map(|n| DVec3::new(n[0].into(), n[1].into(), n[2].into()));
            Some((p_of(&seen, normals, |n| seen.distribution.vndf(wo, n)), format!("ν {:.2} {m} {s} {wo}", seen.nu)))
        };
        cases.iter().enumerate().filter_map(one).collect()
    };
    for (name, ggx) in [("Beckmann on the device", false), ("GGX on the device", true)] {
        let p = run(ggx);
        assert!(p.len() > 10);
        let (lowest, at) = p.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{name}: {} tests, lowest p {lowest:.1e} at {at}", p.len());
        assert!(*lowest > SIGNIFICANCE / p.len() as f64, "{name} on {}: p = {lowest:e} at {at}", gpu.device_name());
    }
}

/// The test must reject a slightly wrong density, and samples of another distribution.
#[test]
fn wrong_densities_and_samplers_are_rejected() {
    let (m, s, wo) = (DVec2::new(0.3, -0.2), DVec3::new(0.3, 0.2, 0.1), direction(70.0, 30.0));
    let rejected = |p: f64| p < 1e-6;
    let (b, g) = (Beckmann::new(m, s), Ggx::new(m, s));
    for (name, m, s) in [
        ("roughness 6 % off", m, 1.12 * s),
        ("mean slope off", m + DVec2::new(0.08, 0.0), s),
        ("mean slope of the other sign", -m, s),
        ("no correlation", m, DVec3::new(s.x, s.y, 0.0)),
    ] {
        let (wb, wg) = (Beckmann::new(m, s), Ggx::new(m, s));
        assert!(rejected(p_of(&Seen::beckmann(&b, wo), samples(&b, wo, 1), |n| wb.vndf(wo, n))), "Beckmann, {name}");
        assert!(rejected(p_of(&Seen::ggx(&g, wo), samples(&g, wo, 2), |n| wg.vndf(wo, n))), "GGX, {name}");
    }
    // The other family; all normals instead of the visible ones (those from straight above).
    assert!(rejected(p_of(&Seen::ggx(&g, wo), samples(&b, wo, 3), |n| g.vndf(wo, n))));
    for d in [&b as &dyn SlopeDistribution, &g] {
        let seen = if std::ptr::addr_eq(d, &b) { Seen::beckmann(&b, wo) } else { Seen::ggx(&g, wo) };
        assert!(rejected(p_of(&seen, samples(d, DVec3::Z, 4), |n| d.vndf(wo, n))));
        assert!(p_of(&seen, samples(d, wo, 5), |n| d.vndf(wo, n)) > 1e-3);
    }
}
