//! The device's masking, skies and interreflection by classes of facets against the f64 reference. `parity/comparator.rs` describes the
//! comparison.

use glam::DVec3;
use leadr_reflectance::frame::from_frame;
use leadr_reflectance::integrals::interreflection::ReliefBounces;
use leadr_reflectance::masking::class_sky::ClassSky;
use leadr_reflectance::masking::classes::{
    Class, ClassesSeen, Correlation, MOST_CLASSES, local_openness, openness_inside,
};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_reflectance::visible::class_environment::{
    GROUND_DIRECTIONS, SKY_DIRECTIONS, ground_direction, mean_cosine, sky_direction, sky_frame,
};
use leadr_reflectance::visible::diffuse::visible_diffuse_moments;
use leadr_testing::gpu::test_gpu;

use super::comparator::{Arguments as _, Numbers, Tolerance, list, parity, v2, v3};
use super::extremes::finite;

/// The numbers of a class: its share, mean slope, slope covariance and depth towards the sky.
const CLASS: usize = 7;

fn open(r: &mut Random) -> f64 {
    if r.unit() < 0.2 { r.pick([0.0, 1.0]) } else { r.range(0.01, 1.0) }
}

/// The number of classes, their numbers, and the number of a direction.
fn arguments(r: &mut Random) -> [f64; 2 + CLASS * MOST_CLASSES] {
    let mut x = vec![(1.0 + 4.0 * r.unit()).floor()];
    for _ in 0..MOST_CLASSES {
        let (m, s) = (0.5 * r.mean_slope(), r.covariance());
        x.extend([r.log(1e-3, 1.0), m.x, m.y, s.x, s.y, s.z, r.log(1e-3, 2.0)]);
    }
    x.push(((SKY_DIRECTIONS + GROUND_DIRECTIONS) as f64 * r.unit()).floor());
    x.try_into().expect("all numbers")
}

fn class(x: &[f64]) -> Class {
    Class { share: x[0], mean: v2(x, 1), covariance: v3(x, 3), height: 0.0, height_variance: 0.0 }
}

#[test]
fn class_masking_parity() {
    parity::<33>(
        "masking/classes",
        Tolerance { relative: 5e-6, floor: |_| 1e-2, unit: |_| 0.0 },
        |r| {
            std::array::from_fn(|k| match k {
                0 | 3 | 6 | 9 => r.log(0.02, 1.1),
                0..12 => r.range(-6.0, 1.0),
                12..16 | 18..22 => open(r),
                24 => r.unit(),
                25..33 => r.range(-2.0, 2.0),
                _ => r.range(-1.5, 1.5),
            })
        },
        |x| {
            let four = |at: usize| [x[at], x[at + 1], x[at + 2], x[at + 3]];
            let seen = |at: usize| ClassesSeen { open: four(at), whitened: v2(x, at + 4) };
            let correlation = std::array::from_fn(|k| {
                let [width, across, opposite] = std::array::from_fn(|i| x[3 * k + i]);
                Correlation { width, across, opposite }
            });
            let lit = |shadowing| seen(12).lit_fractions(shadowing, &correlation, &seen(18));
            list![
                openness_inside(four(12), x[24]).map(|open| open.max(1e-3)),
                lit(Shadowing::None),
                lit(Shadowing::Smith),
                lit(Shadowing::Correlated),
                local_openness(four(12), four(25), four(29))
            ]
        },
    );
}

#[test]
fn class_environment_parity() {
    parity::<45>(
        "visible/class_environment",
        // The variance of cosines is a difference, and so is the blocked part of nearly flat facets.
        Tolerance { relative: 2e-4, floor: |k| if k < 16 && k % 4 == 0 { 10.0 } else { 0.3 }, unit: |_| 0.1 },
        |r| {
            let (wo, x) = (r.direction(), arguments(r));
            std::array::from_fn(|k| match k {
                0..3 => wo[k],
                3..15 => r.unit(),
                _ => x[k - 15],
            })
        },
        |x| {
            let numbers: Vec<&[f64]> = x[16..44].chunks(CLASS).collect();
            let i = x[44].round() as usize;
            let wi = if i < SKY_DIRECTIONS { sky_direction(i) } else { ground_direction(i - SKY_DIRECTIONS) };
            let up = v2(x, 17).extend(-1.0).normalize();
            let wi = from_frame(&sky_frame(-up, v3(x, 0)), wi);
            let count = x[15].round() as usize;
            let mut classes: Vec<Class> = numbers.iter().map(|x| class(x)).collect();
            let depths = std::array::from_fn(|k| numbers[k][6]);
            let sky = ClassSky::new(&classes[..count], depths);
            let blocked = sky.blocked();
            let mut all = vec![];
            for k in 0..MOST_CLASSES {
                let visible = visible_diffuse_moments(v3(x, 0), classes[k].mean, classes[k].covariance, 3);
                all.extend([mean_cosine(&visible, wi), sky.areas[k], sky.flux[k], blocked[k]]);
            }
            classes.truncate(count);
            let whole: f64 = classes.iter().map(|class| class.share).sum();
            let mut shares = [0.0; MOST_CLASSES];
            shares.iter_mut().zip(&classes).for_each(|(share, class)| *share = class.share / whole);
            let bounces = ReliefBounces::new(&sky, &std::array::from_fn(|k| v3(x, 3 + 3 * k)));
            let sees: f64 = blocked.iter().sum();
            all.extend((sees * bounces.radiosity(DVec3::new(1.0, 2.0, 3.0), &sky.flux)).to_array());
            all.extend((sees * bounces.radiosity(DVec3::ONE, &shares)).to_array());
            all
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<45, 42>(&gpu, r, "visible/class_environment", 22, 1, |r| {
        let x = arguments(r);
        std::array::from_fn(|k| if k < 12 { r.unit() as f32 } else { x[k - 12] as f32 })
    });
}
