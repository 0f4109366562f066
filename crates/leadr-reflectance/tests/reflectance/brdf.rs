//! Tests the energy, reciprocity and sampling density of the BRDFs through their public interface. Bounds are two-sided where an exact
//! value is known. The tests print the errors.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::fresnel::{Fresnel, FresnelTable};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution as _;
use leadr_reflectance::frame::{Frame, frame_about, from_frame};
use leadr_reflectance::masking::variants::{Masking, attenuation, geometric_attenuation, smith_g1};
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::lambert::Lambert;
use leadr_reflectance::materials::microfacet::{Microfacet, half_vector};
use leadr_reflectance::quadrature::composite_gauss;
use leadr_reflectance::random::Random;
use leadr_testing::slopes::{Slopes, direction, integrate_directions, polar_about};
use rayon::prelude::*;

fn mirror(masking: Masking, distribution: Slopes) -> Microfacet<Slopes> {
    Microfacet { distribution, masking, fresnel: Fresnel::Ideal }
}

fn pair(r: &mut Random) -> DVec2 {
    DVec2::new(r.unit(), r.unit())
}

const ROUGHNESS: [(f64, f64, f64); 6] =
    [(0.02, 0.02, 0.0), (0.1, 0.4, 0.0), (0.5, 0.5, 0.0), (1.0, 0.4, 0.5), (0.3, 0.6, -0.9998), (2.0, 2.0, 0.0)];

const MEANS: [DVec2; 4] = [DVec2::ZERO, DVec2::new(0.5, -0.3), DVec2::new(-1.5, 1.0), DVec2::new(0.0, 3.0)];

const DEGREES: [f64; 7] = [0.0, 30.0, 60.0, 75.0, 85.0, 88.0, 89.0];

/// Returns every combination of distribution, roughness, mean and view in which at least 1e-4 of the surface is visible.
fn configurations() -> Vec<(Slopes, DVec3)> {
    let mut all = Vec::new();
    for new in Slopes::all() {
        for (x, y, r) in ROUGHNESS {
            for m in MEANS {
                let slopes = new(m, x, y, r);
                let views = DEGREES.into_iter().flat_map(|d| [0.3, 2.5].map(|azimuth| direction(d, azimuth)));
                all.extend(views.filter(|wo| slopes.visible_area(*wo) > 1e-4).map(|wo| (slopes, wo)));
            }
        }
    }
    all
}

/// Returns the lowest and the highest `f` of all configurations, each with its configuration.
fn extremes(all: &[(Slopes, DVec3)], f: impl Fn(&Slopes, DVec3) -> f64 + Sync) -> [(f64, String); 2] {
    let values: Vec<(f64, String)> =
        all.par_iter().map(|(slopes, wo)| (f(slopes, *wo), format!("{:?} viewed from {wo}", slopes.kind))).collect();
    assert!(values.iter().all(|v| v.0.is_finite()));
    let low = values.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().clone();
    let high = values.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap().clone();
    [low, high]
}

#[test]
#[ignore = "long"]
fn white_furnace() {
    let all = configurations();
    let away = all.iter().filter(|(slopes, wo)| slopes.meso_area(*wo) < 0.0).count();
    println!("{} configurations, {away} with a back-facing mesosurface", all.len());
    assert!(away > 10);
    for masking in [Masking::SmithUnshadowed, Masking::VGrooveUnshadowed] {
        // V-grooves on a back-facing mesosurface are invisible.
        let all: Vec<_> = match masking {
            Masking::SmithUnshadowed => all.clone(),
            _ => all.iter().copied().filter(|(slopes, wo)| slopes.meso_area(*wo) > 1e-3).collect(),
        };
        let [low, high] = extremes(&all, |slopes, wo| {
            let brdf = mirror(masking, *slopes);
            integrate_directions(slopes, wo, 16, |wi| brdf.eval_cos(wo, wi)).x - 1.0
        });
        println!("{masking:?}: energy 1 {:+.1e} ({})\n    to 1 {:+.1e} ({})", low.0, low.1, high.0, high.1);
        assert!(low.0 > -1e-5 && high.0 < 1e-5, "{masking:?}");
    }
    // A normal map has no masking. Its energy is the front-facing fraction of the macrosurface, which is 1 at normal incidence.
    let [low, high] = extremes(&all, |slopes, wo| {
        let brdf = mirror(Masking::NormalMap, *slopes);
        integrate_directions(slopes, wo, 16, |wi| brdf.eval_cos(wo, wi)).x
    });
    println!("NormalMap: energy {:.4} ({}) to 1 {:+.1e}", low.0, low.1, high.0 - 1.0);
    assert!(low.0 > 0.0 && (high.0 - 1.0).abs() < 1e-5);
}

#[test]
fn shadowing_only_removes_energy() {
    let all: Vec<_> = configurations().into_iter().step_by(2).collect();
    for masking in [Masking::SmithCorrelated, Masking::SmithSeparable, Masking::VGroove] {
        let all: Vec<_> =
            all.iter().copied().filter(|(s, wo)| masking != Masking::VGroove || s.meso_area(*wo) > 1e-3).collect();
        let [low, high] = extremes(&all, |slopes, wo| {
            let brdf = mirror(masking, *slopes);
            integrate_directions(slopes, wo, 16, |wi| brdf.eval_cos(wo, wi)).x
        });
        println!("{masking:?}: energy {:.4} ({}) to 1 {:+.1e} ({})", low.0, low.1, high.0 - 1.0, high.1);
        assert!(low.0 >= 0.0 && high.0 < 1.0 + 1e-5, "{masking:?}");
    }
    // A nearly smooth surface has almost no shadowing, so it loses almost no energy.
    for new in Slopes::all() {
        let slopes = new(DVec2::ZERO, 0.01, 0.01, 0.0);
        let brdf = mirror(Masking::SmithCorrelated, slopes);
        let wo = direction(40.0, 0.0);
        let a = integrate_directions(&slopes, wo, 24, |wi| brdf.eval_cos(wo, wi)).x;
        assert!((a - 1.0).abs() < 2e-3, "{a}");
    }
    // The thesis's noncentral form creates energy or loses most of it, so it is not the default.
    let [low, high] = extremes(&all, |slopes, wo| {
        let brdf = mirror(Masking::SmithThesis, *slopes);
        integrate_directions(slopes, wo, 16, |wi| brdf.eval_cos(wo, wi)).x
    });
    println!("SmithThesis: energy {:.3} to {:.3} ({})", low.0, high.0, high.1);
    assert!(high.0 > 1.01);
}

#[test]
fn densities_integrate_to_one() {
    let all: Vec<_> = configurations().into_iter().filter(|(s, wo)| s.meso_area(*wo) > 1e-3).step_by(2).collect();
    for masking in [Masking::SmithCorrelated, Masking::VGroove] {
        let [low, high] = extremes(&all, |slopes, wo| {
            let brdf = mirror(masking, *slopes);
            integrate_directions(slopes, wo, 24, |wi| DVec3::splat(brdf.pdf(wo, wi))).x - 1.0
        });
        println!("density of {masking:?}: 1 {:+.1e} to 1 {:+.1e} ({})", low.0, high.0, high.1);
        // The V-groove's density jumps where one side hides the other.
        let bound = if masking == Masking::VGroove { 2e-3 } else { 1e-5 };
        assert!(low.0 > -bound && high.0 < bound, "{masking:?} {} {}", low.1, high.1);
    }
}

/// Tests Helmholtz reciprocity. Central distributions are reciprocal about the macrosurface, and sheared distributions about their
/// mesosurface.
#[test]
fn reciprocity() {
    let mut r = Random(11);
    let mut worst = 0.0f64;
    let mut broken = 0.0f64;
    for _ in 0..20_000 {
        let (x, y, rho) = ROUGHNESS[(r.unit() * 6.0) as usize];
        let m = MEANS[(r.unit() * 4.0) as usize];
        let new = Slopes::all()[(r.unit() * Slopes::all().len() as f64) as usize];
        let slopes = new(m, x, y, rho);
        let wo = direction(89.0 * r.unit(), 2.0 * PI * r.unit());
        let wi = direction(89.0 * r.unit(), 2.0 * PI * r.unit());
        let (ao, ai) = (slopes.meso_area(wo), slopes.meso_area(wi));
        if ao <= 1e-3 || ai <= 1e-3 {
            continue;
        }
        let conductor = Fresnel::Conductor { eta: DVec3::new(0.14, 0.37, 1.4), k: DVec3::new(4.0, 2.4, 1.6) };
        let both = |masking: Masking| {
            let brdf = Microfacet { distribution: slopes, masking, fresnel: conductor.clone() };
            (brdf.eval_cos(wo, wi).x, brdf.eval_cos(wi, wo).x, brdf.eval(wo, wi).x, brdf.eval(wi, wo).x)
        };
        let differ = |a: f64, b: f64| (a - b).abs() / a.abs().max(b.abs()).max(1e-200);
        for masking in [Masking::SmithCorrelated, Masking::SmithSeparable, Masking::VGroove] {
            let (there, back, eval_there, eval_back) = both(masking);
            worst = worst.max(differ(there * ao, back * ai));
            if m == DVec2::ZERO {
                worst = worst.max(differ(eval_there, eval_back));
            }
        }
        let (_, _, there, back) = both(Masking::SmithThesis);
        worst = worst.max(differ(there, back));
        // The test must detect nonreciprocal BRDFs.
        for masking in [Masking::NormalMap, Masking::SmithUnshadowed] {
            let (there, back, ..) = both(masking);
            broken = broken.max(differ(there * ao, back * ai));
        }
    }
    println!("reciprocity: worst relative difference {worst:.1e}; nonreciprocal forms {broken:.2}");
    assert!(worst < 1e-9 && broken > 0.5);
}

#[test]
fn variants_match_their_definitions() {
    let mut r = Random(5);
    let (mut worst, mut above_one, mut beyond_pole) = (0.0f64, 0.0f64, 0);
    for _ in 0..20_000 {
        let (x, y, rho) = ROUGHNESS[(r.unit() * 6.0) as usize];
        let m = MEANS[(r.unit() * 4.0) as usize];
        let new = Slopes::all()[(r.unit() * Slopes::all().len() as f64) as usize];
        let (slopes, central) = (new(m, x, y, rho), new(DVec2::ZERO, x, y, rho));
        let wo = direction(89.0 * r.unit(), 2.0 * PI * r.unit());
        let wi = direction(89.0 * r.unit(), 2.0 * PI * r.unit());
        let wh = half_vector(wo, wi);
        let mut same = |got: f64, want: f64| worst = worst.max((got - want).abs() / want.abs().max(1e-6));
        // Central distributions have the closed forms of thesis Table 2.IV and eq. 2.13.
        let g = |masking: Masking| geometric_attenuation(masking, &central, wo, wi, wh);
        let (go, gi) = (smith_g1(&central, wo), smith_g1(&central, wi));
        same(g(Masking::SmithCorrelated), go * gi / (go + gi - go * gi));
        same(g(Masking::SmithThesis), go * gi / (go + gi - go * gi));
        same(g(Masking::SmithSeparable), go * gi);
        same(g(Masking::SmithUnshadowed), go);
        let groove = |z: f64, w: DVec3| (2.0 * z * wh.z / w.dot(wh)).min(1.0);
        same(g(Masking::VGroove), groove(wo.z, wo).min(groove(wi.z, wi)));
        same(g(Masking::VGrooveUnshadowed), groove(wo.z, wo));
        same(g(Masking::NormalMap), wo.z * wh.z / wo.dot(wh));
        assert!(g(Masking::SmithSeparable) <= g(Masking::SmithCorrelated) * (1.0 + 1e-12));
        assert!(g(Masking::SmithCorrelated) <= go.min(gi) * (1.0 + 1e-12));
        // Sheared distributions have the form of LEADR eq. 13 with eq. 16, and an unclamped G1.
        let (ao, ai) = (slopes.meso_area(wo), slopes.meso_area(wi));
        let (go, gi) = (smith_g1(&slopes, wo), smith_g1(&slopes, wi));
        above_one = above_one.max(go);
        if go > 0.0 && gi > 0.0 {
            // The thesis's form is eq. 2.13 as printed, or 0 where eq. 2.13 is negative.
            let printed = go * gi / (go + gi - go * gi);
            beyond_pole += u32::from(printed < 0.0);
            let got = geometric_attenuation(Masking::SmithThesis, &slopes, wo, wi, wh);
            // Rounding decides the sign near the pole, so the test skips it.
            if (1.0 / go + 1.0 / gi - 1.0).abs() > 1e-3 {
                same(got, printed.max(0.0));
            }
        }
        if ao > 1e-3 && ai > 1e-3 {
            let lambda = |w: DVec3, a: f64| slopes.visible_area(w) / a - 1.0;
            let (lo, li) = (lambda(wo, ao), lambda(wi, ai));
            let f = |masking: Masking| attenuation(masking, &slopes, wo, wi, wh);
            same(f(Masking::SmithCorrelated), 1.0 / (ao * (1.0 + lo + li)));
            same(f(Masking::SmithSeparable), 1.0 / (ao * (1.0 + lo) * (1.0 + li)));
            let facet = wo.dot(wh) / wh.z;
            same(f(Masking::VGroove), (2.0 * ao / facet).min(2.0 * ai / facet).min(1.0) / ao);
        }
    }
    println!("masking forms against their definitions: worst error {worst:.1e}; largest G1 {above_one:.1}");
    println!("eq. 2.13 of the sheared G1 is negative for {beyond_pole} of 20000 pairs");
    assert!(worst < 1e-9 && above_one > 3.0 && beyond_pole > 100);
}

/// `G / a_o` does not jump at an edge-on mesosurface, where `G` and `a_o` both vanish.
#[test]
fn the_edge_on_mesosurface_is_a_limit() {
    for new in Slopes::all() {
        let slopes = new(DVec2::new(1.0, 0.0), 0.4, 0.3, 0.2);
        // The projected area a = cos θ − sin θ is 0 at 45°.
        let at = |degrees: f64, masking: Masking| {
            mirror(masking, slopes).eval_cos(direction(degrees, 0.0), direction(30.0, 3.0)).x
        };
        for masking in Masking::ALL.into_iter().filter(|m| *m != Masking::SmithThesis) {
            let (before, on, after) = (at(45.0 - 1e-7, masking), at(45.0, masking), at(45.0 + 1e-7, masking));
            assert!(before > 0.0 && (before / on - 1.0).abs() < 1e-5 && (after / on - 1.0).abs() < 1e-5, "{masking:?}");
        }
        // The shadowed forms fall to zero where the mesosurface is edge-on to the light.
        let lit = |degrees: f64, masking: Masking| {
            mirror(masking, slopes).eval_cos(direction(30.0, 3.0), direction(degrees, 0.0)).x
        };
        for masking in [Masking::SmithCorrelated, Masking::SmithSeparable, Masking::VGroove] {
            assert!(lit(45.0 - 1e-5, masking) < 1e-4 && lit(45.0 + 1e-5, masking) == 0.0, "{masking:?}");
        }
    }
}

fn materials() -> Vec<(String, Box<dyn Brdf + Sync>, bool)> {
    let mut all: Vec<(String, Box<dyn Brdf + Sync>, bool)> =
        vec![("Lambert".into(), Box::new(Lambert { albedo: DVec3::new(0.2, 0.5, 0.9) }), true)];
    for new in Slopes::all() {
        for (m, x, y, r) in [
            (DVec2::ZERO, 0.35, 0.35, 0.0),
            (DVec2::ZERO, 0.7, 0.25, -0.6),
            (DVec2::new(-0.4, 0.3), 0.5, 0.4, 0.3),
            (DVec2::new(1.5, -0.5), 0.4, 0.3, 0.0),
        ] {
            for masking in [Masking::SmithCorrelated, Masking::VGroove, Masking::NormalMap] {
                let distribution = new(m, x, y, r);
                let name = format!("{masking:?} of {:?}", distribution.kind);
                let fresnel = Fresnel::Schlick(DVec3::new(0.04, 0.5, 1.0));
                all.push((name, Box::new(Microfacet { distribution, masking, fresnel }), false));
            }
        }
    }
    all
}

/// The throughput equals `f_r cos θ / pdf` with the returned `pdf`, and the mean throughput equals the integral.
#[test]
fn samples_have_the_density_they_state() {
    let (mut worst, mut worst_pdf, mut largest, mut worst_sigma) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for (name, brdf, _) in materials() {
        for wo in [direction(5.0, 0.0), direction(50.0, 2.0), direction(85.0, 4.0)] {
            let mut r = Random(77);
            let n = 20_000;
            let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
            for _ in 0..n {
                let Some(s) = brdf.sample(wo, pair(&mut r)) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-12 && s.pdf > 0.0 && s.throughput.is_finite(), "{name}");
                // Near the jump of a V-groove's density, rounding may select either side.
                let pdf_error = (s.pdf / brdf.pdf(wo, s.wi) - 1.0).abs();
                let error = (brdf.eval_cos(wo, s.wi) / s.pdf - s.throughput).abs().max_element();
                worst_pdf = worst_pdf.max(pdf_error);
                worst = worst.max(error);
                largest = largest.max(s.throughput.max_element());
                sum += s.throughput;
                squares += s.throughput * s.throughput;
            }
            let mean = sum / f64::from(n);
            let deviation = ((squares / f64::from(n) - mean * mean) / f64::from(n)).z.max(0.0).sqrt();
            let exact = integrate_polar(wo, 24, |wi| brdf.eval_cos(wo, wi));
            let sigmas = (mean.z - exact.z).abs() / (deviation + 1e-3);
            worst_sigma = worst_sigma.max(sigmas);
            assert!(sigmas < 4.5, "{name} from {wo}: {} by samples, {} by quadrature", mean.z, exact.z);
        }
    }
    println!(
        "throughput against eval·cos/pdf: worst {worst:.1e}; pdf {worst_pdf:.1e}; largest throughput {largest:.3}"
    );
    println!("mean of samples against quadrature: worst {worst_sigma:.1} standard deviations");
    assert!(worst < 1e-7 && worst_pdf < 1e-7 && largest <= 2.0 + 1e-9);
}

/// Computes `∫ f dwi` in polar coordinates about `wo`, without a change of variables to slopes.
fn integrate_polar(wo: DVec3, panels: usize, f: impl Fn(DVec3) -> DVec3) -> DVec3 {
    let frame = frame_about(wo);
    let mut sum = DVec3::ZERO;
    for (theta, wt) in composite_gauss(0.0, 0.5 * PI, panels, 8) {
        for (phi, wp) in composite_gauss(0.0, 2.0 * PI, 2 * panels, 8) {
            sum += wt * wp * 2.0 * (2.0 * theta).sin() * f(about(&frame, theta, phi));
        }
    }
    sum
}

/// Returns the direction whose half vector with the frame's z axis has the polar angles `theta` and `phi` about this axis.
fn about(frame: &Frame, theta: f64, phi: f64) -> DVec3 {
    let (sin, cos) = (2.0 * theta).sin_cos();
    from_frame(frame, DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))
}

const RINGS: usize = 16;
const SECTORS: usize = 16;

/// Returns the probability of each cell of the polar grid about `wo`. The last entry is the probability that there is no sample.
fn expected(wo: DVec3, pdf: impl Fn(DVec3) -> f64 + Sync) -> Vec<f64> {
    let frame = frame_about(wo);
    let (ring, sector) = (0.5 * PI / RINGS as f64, 2.0 * PI / SECTORS as f64);
    let mut cells: Vec<f64> = (0..RINGS * SECTORS)
        .into_par_iter()
        .map(|cell| {
            let (t0, p0) = (ring * (cell / SECTORS) as f64, sector * (cell % SECTORS) as f64);
            // The grid is fine because GGX does not vanish where half vectors reach the horizon.
            let inner = composite_gauss(p0, p0 + sector, 8, 4);
            let mut sum = 0.0;
            for (theta, wt) in composite_gauss(t0, t0 + ring, 8, 4) {
                for &(phi, wp) in &inner {
                    sum += wt * wp * 2.0 * (2.0 * theta).sin() * pdf(about(&frame, theta, phi));
                }
            }
            sum
        })
        .collect();
    cells.push((1.0 - cells.iter().sum::<f64>()).max(0.0));
    cells
}

/// Returns Pearson's statistic as a standard normal deviate (Wilson and Hilferty). Cells with an expected count below 8 are pooled.
fn chi_square(counts: &[u32], expected: &[f64], n: u32) -> f64 {
    let (mut statistic, mut cells, mut pooled) = (0.0, 0, (0.0, 0.0));
    for (&count, &p) in counts.iter().zip(expected) {
        let (count, want) = (f64::from(count), p * f64::from(n));
        if want < 8.0 {
            pooled = (pooled.0 + count, pooled.1 + want);
        } else {
            statistic += (count - want).powi(2) / want;
            cells += 1;
        }
    }
    if pooled.1 > 1.0 {
        statistic += (pooled.0 - pooled.1).powi(2) / pooled.1;
        cells += 1;
    } else if pooled.0 > 20.0 {
        return f64::INFINITY;
    }
    let k = f64::from(cells - 1);
    ((statistic / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

fn histogram(wo: DVec3, brdf: &dyn Brdf, n: u32) -> Vec<u32> {
    let mut counts = vec![0; RINGS * SECTORS + 1];
    let mut r = Random(2013);
    for _ in 0..n {
        let cell = match brdf.sample(wo, pair(&mut r)) {
            None => RINGS * SECTORS,
            Some(s) => {
                let (theta, phi) = polar_about(wo, s.wi);
                let ring = ((theta / (0.5 * PI) * RINGS as f64) as usize).min(RINGS - 1);
                ring * SECTORS + ((phi / (2.0 * PI) * SECTORS as f64) as usize).min(SECTORS - 1)
            }
        };
        counts[cell] += 1;
    }
    counts
}

#[test]
#[ignore = "long"]
fn samples_follow_their_density() {
    let n = 100_000;
    let views = [direction(0.0, 0.0), direction(40.0, 1.0), direction(75.0, 3.5), direction(88.0, 5.0)];
    let materials = materials();
    let results: Vec<(f64, String)> = materials
        .par_iter()
        .flat_map_iter(|(name, brdf, _)| {
            views.map(|wo| {
                let want = expected(wo, |wi| brdf.pdf(wo, wi));
                (chi_square(&histogram(wo, brdf.as_ref(), n), &want, n), format!("{name} from {wo}"))
            })
        })
        .collect();
    let worst = results.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    println!("{} chi-square tests of {n} samples: worst deviate {:+.2} ({})", results.len(), worst.0, worst.1);
    assert!(worst.0 < 4.0);
    // A fit that is always better than average would also be wrong, because the statistic of a fair sampler scatters about 0.
    assert!(results.iter().any(|r| r.0 > 0.0) && results.iter().any(|r| r.0 < 0.0));
}

/// The test must detect a roughness error of 5 %, and a missing mean slope.
#[test]
fn chi_square_rejects_wrong_samples() {
    let n = 100_000;
    let wo = direction(40.0, 1.0);
    for new in Slopes::all() {
        let mut deviates = Vec::new();
        for (m, scale) in [(DVec2::ZERO, 1.05), (DVec2::new(0.04, 0.0), 1.0)] {
            let drawn = mirror(Masking::SmithCorrelated, new(DVec2::ZERO, 0.35, 0.35, 0.0));
            let stated = mirror(Masking::SmithCorrelated, new(m, 0.35 * scale, 0.35 * scale, 0.0));
            let want = expected(wo, |wi| stated.pdf(wo, wi));
            deviates.push(chi_square(&histogram(wo, &drawn, n), &want, n));
        }
        println!("wrong densities give {deviates:.1?}");
        assert!(deviates.iter().all(|d| *d > 6.0));
    }
}

/// The results are finite even for arguments that no scene should produce.
#[test]
fn finite_for_every_input() {
    let axes = [0.0, 1.0, -1.0, 1e-7, -1e-4, 1e-20];
    let directions: Vec<DVec3> = (0..216)
        .map(|i| DVec3::new(axes[i / 36], axes[i / 6 % 6], axes[i % 6]))
        .filter_map(DVec3::try_normalize)
        .collect();
    let table = FresnelTable::new(vec![DVec3::ZERO, DVec3::ONE]).unwrap();
    for new in Slopes::all() {
        for m in [DVec2::ZERO, DVec2::new(100.0, -50.0), DVec2::new(1e-12, 0.5)] {
            for (x, y, r) in [(0.0, 0.0, 0.0), (1e-9, 1.0, 1.0), (1.0, 1.0, -1.0), (100.0, 1e-4, 0.5), (0.5, 0.5, 0.0)]
            {
                for masking in Masking::ALL {
                    let distribution = new(m, x, y, r);
                    let fresnel = Fresnel::Tabulated(table.clone());
                    let brdf = Microfacet { distribution, masking, fresnel };
                    for &wo in directions.iter().step_by(3) {
                        for &wi in directions.iter().chain([&-wo, &wo]).step_by(2) {
                            let values = [brdf.eval_cos(wo, wi).x, brdf.eval(wo, wi).x, brdf.pdf(wo, wi)];
                            let fine = values.iter().all(|v| v.is_finite() && *v >= 0.0);
                            assert!(fine, "{values:?}: {masking:?} {distribution:?} {wo} {wi}");
                        }
                        for u in [DVec2::ZERO, DVec2::splat(0.5), DVec2::splat(1.0 - 1e-16), DVec2::new(0.0, 0.999)] {
                            if let Some(s) = brdf.sample(wo, u) {
                                let fine = s.wi.is_finite() && s.pdf.is_finite() && s.throughput.is_finite();
                                assert!(fine, "{s:?}: {masking:?} {distribution:?} {wo} {u}");
                            }
                        }
                    }
                }
            }
        }
    }
}
