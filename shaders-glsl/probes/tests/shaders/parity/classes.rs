//! The device's masking and shadowing by classes of facets against the f64 reference. `parity/comparator.rs` describes the comparison.

use super::comparator::{Arguments as _, Numbers, Tolerance, list, parity, v2, v3};
use super::extremes::finite;
use leadr_reflectance::masking::classes::{Class, ClassHiding, MOST_CLASSES};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_testing::gpu::test_gpu;

/// The numbers of a class: its share, mean slope, slope covariance, and mean and variance of heights.
const CLASS: usize = 8;

/// The number of classes, and their numbers. Classes are at equal, different and far apart heights.
fn arguments(r: &mut Random) -> [f64; 1 + CLASS * MOST_CLASSES] {
    let mut x = vec![(1.0 + 4.0 * r.unit()).floor()];
    let unit = r.log(1e-3, 1e3);
    for _ in 0..MOST_CLASSES {
        let (m, s) = (0.5 * r.mean_slope(), r.covariance());
        x.extend([r.log(1e-3, 1.0), m.x, m.y, s.x, s.y, s.z]);
        x.extend([unit * r.range(-1.0, 1.0), unit * unit * r.log(1e-3, 1.0)]);
    }
    x.try_into().expect("all numbers")
}

fn classes(x: &[f64]) -> Vec<Class> {
    let class =
        |x: &[f64]| Class { share: x[0], mean: v2(x, 1), covariance: v3(x, 3), height: x[6], height_variance: x[7] };
    x[1..].chunks(CLASS).take(x[0].round() as usize).map(class).collect()
}

#[test]
fn class_masking_parity() {
    parity::<39>(
        "masking/classes",
        // The bend of a class is a difference of logarithms.
        Tolerance { relative: 2e-5, floor: |k| if k < 4 { 1e-3 } else { 1e-1 }, unit: |_| 0.1 },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            let x = arguments(r);
            std::array::from_fn(|k| match k {
                0..3 => wo[k],
                3..6 => wi[k - 3],
                _ => x[k - 6],
            })
        },
        |x| {
            let hiding = ClassHiding::new(&classes(&x[6..]));
            let (o, i) = (hiding.depths(v3(x, 0)), hiding.depths(v3(x, 3)));
            // Absent classes are 0.
            let present = |values: [f64; MOST_CLASSES]| {
                std::array::from_fn::<_, MOST_CLASSES, _>(|k| if (k as f64) < x[6].round() { values[k] } else { 0.0 })
            };
            let lit = |shadowing| present(o.lit_fractions(shadowing, &i));
            list![
                hiding.mean,
                [o.lambda, o.meso],
                present(o.areas),
                present(o.open_fractions()),
                present(o.visible_shares()),
                lit(Shadowing::None),
                lit(Shadowing::Smith),
                lit(Shadowing::Correlated),
                lit(Shadowing::CorrelatedSimple),
                present(hiding.bend),
            ]
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<39, 33>(&gpu, r, "masking/classes", 36, 2, |r| arguments(r).map(|x| x as f32));
}
