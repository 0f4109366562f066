//! Tests the specular reflection of a base that is rough in each facet's own frame. A Monte Carlo sum over Gaussian facets gives the errors
//! of the closed-form covariances.

use glam::{DMat2, DVec2, DVec3};
use leadr_reflectance::facets::base_roughness::add_facet_roughness;
use leadr_reflectance::facets::fresnel::fresnel_schlick;
use leadr_reflectance::facets::projected_area::visible_area;
use leadr_reflectance::frame::{frame_about, from_frame, to_frame};
use leadr_reflectance::masking::smith::shadowing_given_masking;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};
use leadr_reflectance::slopes::statistics::add_roughness;

const SAMPLES: usize = 6000;
const F0: DVec3 = DVec3::splat(0.04);
/// The brightest directions of the environments. The radiance falls by a factor of e² at right angles to the brightest direction.
const BRIGHTEST: [[f64; 3]; 5] =
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 0.3]];

/// The specular radiance under seven skies: the five of `BRIGHTEST`, a white sky, and a sky that darkens with the cosine from the zenith.
type Seen = [f64; 7];

/// A relief, a base and a view.
struct Case {
    s: DVec3,
    m: DVec2,
    alpha: f64,
    wo: DVec3,
}

fn gaussian(random: &mut Random) -> DVec2 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    DVec2::from_angle(std::f64::consts::TAU * random.unit()) * radius
}

/// Adds the reflection of each sky by one microfacet of normal `wn` and visible area `area` to `seen`. `lit` returns the fraction of the
/// microfacet that is lit.
fn reflect(seen: &mut Seen, wo: DVec3, wn: DVec3, area: f64, lit: impl Fn(DVec3) -> f64) {
    let cosine = wo.dot(wn);
    let wi = 2.0 * cosine * wn - wo;
    if wi.z <= 0.0 {
        return;
    }
    let share = area * fresnel_schlick(F0, cosine.max(0.0)).x * lit(wi);
    for (sum, brightest) in seen.iter_mut().zip(BRIGHTEST) {
        *sum += share * (2.0 * (wi.dot(DVec3::from_array(brightest).normalize()) - 1.0)).exp();
    }
    seen[5] += share;
    seen[6] += share * wi.z;
}

/// Computes the reference: facets of the relief, each with a Beckmann base in its own frame.
fn truth(case: &Case) -> Seen {
    let Case { s, m, alpha, wo } = *case;
    let (mut random, mut seen, mut total) = (Random(1), [0.0; 7], 0.0);
    let (cholesky, base) = (slope_cholesky(s), DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0));
    for _ in 0..SAMPLES {
        let slope = slope_at(gaussian(&mut random), m, cholesky);
        let frame = frame_about(normal_of_slope(slope));
        let local = to_frame(&frame, wo);
        // The two projected areas are of the facet per area of macrosurface, and of the microfacet per area of facet.
        let facet = (wo.z - wo.truncate().dot(slope)).max(0.0);
        let on_facet = gaussian(&mut random) * (alpha * 0.5f64.sqrt());
        let mirror = (local.z - local.truncate().dot(on_facet)).max(0.0);
        let area = facet * mirror / visible_area(local, DVec2::ZERO, base).max(1e-9);
        total += area;
        reflect(&mut seen, wo, from_frame(&frame, normal_of_slope(on_facet)), area, |wi| {
            let inside = to_frame(&frame, wi);
            let of_base =
                if inside.z > 0.0 { shadowing_given_masking(local, inside, DVec2::ZERO, base, true) } else { 0.0 };
            of_base * shadowing_given_masking(wo, wi, m, s, true)
        });
    }
    seen.map(|v| v / total)
}

/// Computes the radiance of a single Gaussian of covariance `s` for all microfacets.
fn model(case: &Case, s: DVec3) -> Seen {
    let Case { m, wo, .. } = *case;
    let (mut random, mut seen, mut total) = (Random(2), [0.0; 7], 0.0);
    let cholesky = slope_cholesky(s);
    for _ in 0..SAMPLES {
        let slope = slope_at(gaussian(&mut random), m, cholesky);
        let area = (wo.z - wo.truncate().dot(slope)).max(0.0);
        total += area;
        reflect(&mut seen, wo, normal_of_slope(slope), area, |wi| shadowing_given_masking(wo, wi, m, s, true));
    }
    seen.map(|v| v / total)
}

/// Returns the mean of `(1 + |x|²)(I + x xᵀ)` over the relief, which has the exact variance but the wrong shape.
fn mean_of_facets(case: &Case) -> DVec3 {
    let Case { s, m, alpha, .. } = *case;
    let relief = DMat2::from_cols(DVec2::new(s.x, s.z), DVec2::new(s.z, s.y));
    let square = |v: DVec2| DMat2::from_cols(v * v.x, v * v.y);
    let a = relief + square(m);
    let trace = a.x_axis.x + a.y_axis.y;
    let mean = DMat2::IDENTITY * (1.0 + trace) + a + a * trace + a * a * 2.0 - square(m) * (2.0 * m.length_squared());
    s + 0.5 * alpha * alpha * DVec3::new(mean.x_axis.x, mean.y_axis.y, mean.x_axis.y)
}

fn error(seen: &Seen, truth: &Seen) -> f64 {
    let square = |f: &dyn Fn(usize) -> f64| (0..7).map(|k| f(k).powi(2)).sum::<f64>();
    (square(&|k| seen[k] - truth[k]) / square(&|k| truth[k])).sqrt()
}

fn cases(s: &[DVec3], means: &[DVec2], angles: &[f64]) -> Vec<Case> {
    let mut cases = Vec::new();
    for &s in s {
        for alpha in [0.05, 0.2, 0.35, 0.6] {
            for &m in means {
                for angle in angles {
                    let (sine, cosine) = angle.to_radians().sin_cos();
                    cases.push(Case { s, m, alpha, wo: DVec3::new(sine, 0.0, cosine) });
                }
            }
        }
    }
    cases
}

#[test]
#[ignore = "long"]
fn facet_roughness_is_nearer_to_facets_than_the_paper() {
    let isotropic = |deviation: f64| DVec3::new(deviation * deviation, deviation * deviation, 0.0);
    let centred = [0.1, 0.25, 0.4, 0.55, 0.75, 1.0].map(isotropic);
    let stretched = [DVec3::new(0.25, 0.04, 0.0), DVec3::new(0.04, 0.25, 0.0), DVec3::new(0.6, 0.2, 0.2)];
    let tilts = [DVec2::new(0.3, 0.0), DVec2::new(-0.3, 0.0), DVec2::new(0.0, 0.5), DVec2::new(-0.7, 0.0)];
    let views = [0.0, 25.0, 45.0, 60.0, 72.0, 82.0];
    for (name, cases, bound) in [
        ("centred", cases(&centred, &[DVec2::ZERO], &views), 0.4),
        ("stretched", cases(&stretched, &[DVec2::ZERO], &views), 0.4),
        ("tilted", cases(&centred[1..], &tilts, &views[..4]), 0.9),
    ] {
        let mut sums = [0.0; 4];
        let mut worst = [0.0f64; 4];
        for case in &cases {
            let truth = truth(case);
            let facet = add_facet_roughness(case.s, case.alpha, case.wo, case.m);
            // Without a base the model is exact, so its difference from the reference is the sampling error.
            let bare = Case { alpha: 1e-4, ..*case };
            let forms = [
                error(&model(case, add_roughness(case.s, case.alpha)), &truth),
                error(&model(case, mean_of_facets(case)), &truth),
                error(&model(case, facet), &truth),
                error(&model(&bare, case.s), &self::truth(&bare)),
            ];
            for k in 0..4 {
                sums[k] += forms[k] * forms[k];
                worst[k] = worst[k].max(forms[k]);
            }
        }
        let rms = sums.map(|sum| (sum / cases.len() as f64).sqrt());
        println!("{name}: macrosurface, mean over facets, this form, sampling: rms {rms:.3?} worst {worst:.3?}");
        assert!(rms[2] < bound * rms[0] && worst[2] < worst[0], "{name}: {rms:?} {worst:?}");
    }
}

#[test]
fn facet_roughness_has_its_limits() {
    let wo = DVec3::new(0.6, 0.0, 0.8);
    let (s, m) = (DVec3::new(0.3, 0.1, -0.05), DVec2::new(0.2, -0.4));
    assert_eq!(add_facet_roughness(s, 0.0, wo, m), s);
    let smooth = add_facet_roughness(DVec3::ZERO, 0.3, wo, DVec2::ZERO);
    assert!((smooth - DVec3::new(0.045, 0.045, 0.0)).length() < 1e-15);
    // A single tilted facet has the base's variance in its own frame, to first order.
    let facet = add_facet_roughness(DVec3::ZERO, 0.3, wo, DVec2::new(0.5, 0.0));
    assert!((facet - 0.045 * DVec3::new(1.25 * 1.25, 1.25, 0.0)).length() < 1e-15, "{facet}");
    let mut random = Random(7);
    for _ in 0..10_000 {
        let deviation = 10f64.powf(4.0 * random.unit() - 2.0);
        let (x, y) = (deviation, deviation * random.unit());
        let s = DVec3::new(x * x, y * y, x * y * (2.0 * random.unit() - 1.0));
        let m = gaussian(&mut random) * deviation;
        let wo = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit()).normalize();
        let sum = add_facet_roughness(s, random.unit(), wo, m);
        assert!(sum.is_finite() && sum.x > 0.0 && sum.x * sum.y >= sum.z * sum.z, "{sum} of {s}");
        assert!(sum.x + sum.y < s.x + s.y + 40.0 + 15.0 * deviation, "{sum} of {s}");
    }
}
