//! Measures numbers from Chan's *Material Advances in Call of Duty: WWII* (2018) that no other example measures: the precision of stored
//! lengths, separate filtering of gloss and normals, hidden directions, BRDF slices, and the energy that diffuse models gain or lose.
//! `docs/measurements/chan-2018.md` lists the results.
//!
//! `cargo run --release --example 22_chan_2018 [WALKS]`

use std::f64::consts::PI;

use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::facets::gloss::{GLOSS_ADVANCED_WARFARE, GLOSS_WWII, Gloss, gloss_alpha};
use leadr::reflectance::facets::shortened_normals::Shortening;
use leadr::reflectance::masking::occlusion::{Hidden, adjusted_visibility};
use leadr::reflectance::materials::diffuse_models::{disney_diffuse, oren_nayar};
use leadr::reflectance::materials::energy::EnergyTable;
use leadr::reflectance::materials::microfacet::half_vector;
use leadr::reflectance::materials::multiscattering::{chan_diffuse, chan_rational_rough};
use leadr::reflectance::quadrature::composite_gauss;
use leadr::reflectance::random::Random;
use leadr::reflectance::{DVec2, DVec3};
use leadr_lab::facet_walk::{Facets, facet_walks};
use rayon::prelude::*;

/// GGX facets weighted by macrosurface area.
const MACRO: Shortening = Shortening::ALL[0];
/// GGX facets weighted by their own area.
const MICRO: Shortening = Shortening::ALL[1];

fn main() {
    let walks = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(10_000);
    gloss();
    stored_lengths();
    filtered_apart();
    hidden_directions();
    diffuse_models();
    slices(walks);
}

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let s = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    DVec3::new(s * azimuth.cos(), s * azimuth.sin(), cosine)
}

/// Prints the numbers of section 1.1 and figure 6.
fn gloss() {
    for (name, curve) in [("eq. 1", GLOSS_ADVANCED_WARFARE), ("eq. 2", GLOSS_WWII)] {
        println!("{name}: α {:.5} at gloss 0, {:.5} at 1", gloss_alpha(0.0, curve), gloss_alpha(1.0, curve));
    }
    let apart = |g: f64| {
        let alpha = Gloss::Wwii.alpha(g);
        (MACRO.length(alpha) - MICRO.length(alpha), g)
    };
    let most = (0..=1000).map(|i| apart(f64::from(i) / 1000.0)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    println!(
        "figure 6: lengths at gloss 0: {:.4} macro, {:.4} micro; largest difference {:.4} at {:.3}",
        MACRO.length(1.0),
        MICRO.length(1.0),
        most.0,
        most.1
    );
    let read = |g: f64| Gloss::Wwii.gloss(MICRO.alpha_of_length(MACRO.length(Gloss::Wwii.alpha(g)))) - g;
    let worst = (0..=1000).map(|i| read(f64::from(i) / 1000.0)).fold(0.0f64, |a, b| a.max(b.abs()));
    println!("    maximum gloss error of a macro length read as micro: {worst:.4}");
}

/// Prints the precision of a stored length (section 2.2).
fn stored_lengths() {
    let worst = |store: &dyn Fn(f64) -> f64| {
        (0..=4000).map(|i| f64::from(i) / 4000.0).fold((0.0f64, 0.0), |worst, g| {
            let length = store(MACRO.length(Gloss::Wwii.alpha(g)));
            let error = (Gloss::Wwii.gloss(MACRO.alpha_of_length(length)) - g).abs();
            if error > worst.0 { (error, g) } else { worst }
        })
    };
    let steps = |n: f64| move |x: f64| (x * n).round() / n;
    for (name, (error, at)) in [
        ("8 bits", worst(&steps(255.0))),
        ("half, steps of 2^-11 below 1", worst(&steps(2048.0))),
        ("4 decimals", worst(&steps(1e4))),
        ("5 decimals", worst(&steps(1e5))),
        ("16 bits", worst(&steps(65535.0))),
        ("6 decimals", worst(&steps(1e6))),
        ("float", worst(&|x| f64::from(x as f32))),
    ] {
        println!("stored lengths, {name}: maximum gloss error {error:.4} at {at:.3}");
    }
}

/// Compares separately filtered gloss and normals with shortened normals, half-way between two texels (section 2.2).
fn filtered_apart() {
    for degrees in [1.0f64, 3.0, 10.0, 30.0, 60.0] {
        let (mut gloss, mut rotation, mut signed) = (0.0f64, 0.0f64, 0.0);
        for (i, j) in (0..=16).flat_map(|i| (0..=16).map(move |j| (i, j))) {
            let [a, b] = [i, j].map(|k| f64::from(k) / 16.0);
            let half = 0.5 * degrees.to_radians();
            let normals = [-half, half].map(|t: f64| DVec2::new(t.sin(), t.cos()));
            let lengths = [a, b].map(|g| MACRO.length(Gloss::Wwii.alpha(g)));
            let mean = 0.5 * (lengths[0] * normals[0] + lengths[1] * normals[1]);
            let whole = Gloss::Wwii.gloss(MACRO.alpha_of_length(mean.length()));
            let off = 0.5 * (a + b) - whole;
            gloss = gloss.max(off.abs());
            signed += off / 17.0 / 17.0;
            rotation = rotation.max(mean.x.atan2(mean.y).to_degrees().abs());
        }
        println!(
            "filtered separately, normals {degrees}° apart: gloss error {gloss:.3} maximum, {signed:+.3} mean; direction error {rotation:.2}° at most"
        );
    }
    // In figure 7, a rough texel is on the left and a smooth texel on the right.
    let [rough, smooth] = [0.1, 0.9].map(|g| MACRO.length(Gloss::Wwii.alpha(g)));
    let half = 20f64.to_radians();
    let mean = rough * DVec2::new(-half.sin(), half.cos()) + smooth * DVec2::new(half.sin(), half.cos());
    println!(
        "figure 7, gloss .1 and .9, 40° apart: the mean is {:+.2}° from the middle, towards the smooth normal",
        mean.x.atan2(mean.y).to_degrees()
    );
}

/// Compares eq. 48 with all bounces, eq. 49 (section 4.4).
fn hidden_directions() {
    for rho in [0.2, 0.5, 0.8, 0.9] {
        let off = |a: f64| {
            let of = |hidden| adjusted_visibility(hidden, a, DVec3::splat(rho)).x;
            (of(Hidden::SameRadiance) - of(Hidden::SameOccluded), a)
        };
        let most =
            (0..=1000).map(|i| off(f64::from(i) / 1000.0)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        println!("eq. 49 − eq. 48, albedo {rho}: up to {:.3}, at visibility {:.3}", most.0, most.1);
    }
}

/// Returns `∫ f c dω / π`.
fn albedo(brdf: impl Fn(DVec3) -> f64) -> f64 {
    let azimuths = composite_gauss(0.0, PI, 4, 12);
    let ring = |c: f64| azimuths.iter().map(|(phi, w)| 2.0 * w * brdf(direction(c, *phi))).sum::<f64>();
    composite_gauss(0.0, 1.0, 6, 12).into_iter().map(|(u, w)| w * 2.0 * u * u * u * ring(u * u)).sum::<f64>() / PI
}

fn chan(wo: DVec3, wi: DVec3, gloss: f64) -> f64 {
    let h = half_vector(wo, wi);
    chan_diffuse(wi.z, wo.z, h.z, wi.dot(h), gloss)
}

/// Prints the numbers of sections 5.3, 5.4 and 5.8.
fn diffuse_models() {
    let cosines = [0.001, 0.05, 0.2, 0.5, 0.8, 1.0];
    for roughness in [0.0, 0.5, 1.0] {
        let row = cosines.map(|c| albedo(|wi| disney_diffuse(direction(c, 0.0), wi, roughness * roughness)));
        println!("Disney's diffuse model, roughness {roughness}: albedo at cosines {cosines:?} {row:.3?}");
    }
    for alpha in [0.0, 0.5, 1.0] {
        let row = cosines.map(|c| albedo(|wi| oren_nayar(direction(c, 0.0), wi, alpha, DVec3::ONE).x));
        println!("Oren-Nayar, α {alpha}: albedo {row:.3?}");
    }
    // Figure 23 compares listing 1 with Lambert's law times the transmission of the coat (listing 5), by the cosine of the light.
    let table = EnergyTable::ggx();
    for gloss in [0.25, 0.5, 0.75, 1.0] {
        let left = cosines.map(|c| 1.0 - table.albedo(Gloss::Wwii.alpha(gloss), c).of(DVec3::splat(0.04)).x);
        let fit = cosines.map(|c| albedo(|wi| chan(direction(c, 0.0), wi, gloss)));
        println!("gloss {gloss}: albedo of listing 1 {fit:.3?}; of Lambert with energy conservation {left:.3?}");
    }
    // The bump of eq. 68 is negative between its roots.
    let n = 60;
    let cosine = |k: usize| (k as f64 / n as f64).powi(2).max(1e-3);
    let least = (0..=40usize).into_par_iter().map(|g| {
        let gloss = g as f64 / 40.0;
        let all = (0..=n).flat_map(|i| (0..=n).flat_map(move |j| (0..=24).map(move |k| (i, j, k))));
        let values = all.map(|(i, j, k)| {
            (
                chan(direction(cosine(i), 0.0), direction(cosine(j), PI * f64::from(k) / 24.0), gloss),
                cosine(i),
                cosine(j),
                7.5 * f64::from(k),
            )
        });
        let first = (f64::MAX, 0.0, 0.0, 0.0);
        (values.fold(first, |a, b| if b.0 < a.0 { b } else { a }), gloss)
    });
    let least: Vec<_> = least.collect();
    let negative: Vec<f64> = least.iter().filter(|l| l.0.0 < 0.0).map(|l| l.1).collect();
    let worst = least.iter().min_by(|a, b| a.0.0.total_cmp(&b.0.0)).expect("41 of them");
    println!(
        "minimum of listing 1 at gloss {:.3}: {:.3} at cosines {:.4} and {:.4}, azimuth {}°; below 0 from gloss {:?} to {:?}",
        worst.1,
        worst.0.0,
        worst.0.1,
        worst.0.2,
        worst.0.3,
        negative.first(),
        negative.last()
    );
    let retro = |c: f64| chan(direction(c, 0.0), direction(c, 0.0), 0.85);
    let until = (1..=10_000).map(|i| f64::from(i) * 1e-5).take_while(|&c| retro(c) < 0.0).last();
    println!("    towards the light at gloss .85: below 0 for cosines up to {until:?}");
}

/// Measures the error of the slice at `φ_d = 90°` as a model of the random walks' BRDF (sections 5.6 and 5.7). The error is the RMS of `π
/// f_r` over pairs of cosine-distributed directions.
fn slices(count: u64) {
    let pairs = 160u64;
    for gloss in [0.0, 60.0, 120.0, 180.0, 240.0] {
        let facets = Ggx::isotropic(DVec2::ZERO, Gloss::Wwii.alpha(gloss / 255.0));
        let errors: Vec<[f64; 5]> = (0..pairs)
            .into_par_iter()
            .map(|i| {
                let mut random = Random::stream(5, i);
                let mut draw = || direction(random.unit().sqrt().max(1e-3), random.range(0.0, 2.0 * PI));
                let (wo, wi) = (draw(), draw());
                let walked = |o: DVec3, i: DVec3, seed: u64| {
                    let found = facet_walks(&facets, Facets::Diffuse(0.04), i, &[o], count, seed);
                    PI * found.towards[0].iter().sum::<f64>() / o.z
                };
                let h = half_vector(wo, wi);
                let (x, y) = (h.z.clamp(0.0, 1.0), wi.dot(h).clamp(0.0, 1.0));
                let [sx, sy] = [x, y].map(|c| (1.0 - c * c).max(0.0).sqrt());
                let [o, i] = [1.0, -1.0].map(|side| DVec3::new(sx * y, side * sy, x * y));
                // The result is averaged over both directions of the light, which are equal by reciprocity.
                let whole = |o, i, seed| 0.5 * (walked(o, i, seed) + walked(i, o, seed + 1));
                let (full, again, slice) = (whole(wo, wi, 11), whole(wo, wi, 21), whole(o, i, 31));
                let rational = PI * chan_rational_rough(x, y);
                [slice - full, again - full, 1.0 - full, rational - slice, rational - full].map(|e| e * e)
            })
            .collect();
        let rms = [0, 1, 2, 3, 4].map(|k| (errors.iter().map(|e| e[k]).sum::<f64>() / pairs as f64).sqrt());
        println!(
            "gloss {gloss}: slice − walks {:.3}, walks − walks {:.3}, Lambert − walks {:.3}; eq. 63 − slice {:.3}, − walks {:.3}",
            rms[0], rms[1], rms[2], rms[3], rms[4]
        );
    }
}
