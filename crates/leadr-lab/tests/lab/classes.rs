//! Masking, skies and interreflection by classes of facets, compared with ray casts of reliefs with hard edges.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use leadr_lab::hard_edges::{bricks, grooves, studs, tiles};
use leadr_lab::ray_cast::{Facet, Patch};
use leadr_lab::relief::Relief;
use leadr_maps::{HeightMap, load_height_map};
use leadr_reflectance::facets::projected_area::{meso_area, visible_area};
use leadr_reflectance::frame::from_frame;
use leadr_reflectance::integrals::diffuse::NormalMoments;
use leadr_reflectance::integrals::interreflection::ReliefBounces;
use leadr_reflectance::masking::class_sky::ClassSky;
use leadr_reflectance::masking::classes::{Class, ClassesSeen, MOST_CLASSES};
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction, whitened_direction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_cholesky};
use leadr_reflectance::visible::class_environment::{
    SKY_DIRECTIONS, mean_cosine, sky_direction, sky_frame, sky_seen, sky_weight,
};
use leadr_reflectance::visible::diffuse::visible_diffuse_moments;
use leadr_testing::shared::shared_data;
use leadr_testing::standard::direction;

const SIZE: u32 = 512;

/// The bounds of the errors of a relief.
struct Bounds {
    /// The root mean square of the shares of the visible classes.
    shares: f64,
    /// The root mean square of the lit fraction of the visible facets.
    lit: f64,
    /// The relative error of the light of a sky, up to 75 degrees.
    sky: f64,
    /// The relative error of the light of a sun after all bounces, in the mean over viewers and lights.
    bounces: f64,
    /// The angle between the mean directions of light, in degrees, in the mean over classes and viewers.
    lean: f64,
}

fn scan(name: &str, depth: f64) -> Option<Relief> {
    let folder = shared_data(&format!("displacement/{name}"))?;
    let map = load_height_map(folder.join(format!("{name}_1K-PNG_Displacement.png"))).expect("a height map");
    let cells = map.width / SIZE;
    let mean = |i: u32| {
        let (x, y) = (i % SIZE * cells, i / SIZE * cells);
        let texels = (0..cells * cells).map(|k| map.texels[((y + k / cells) * map.width + x + k % cells) as usize]);
        texels.sum::<f32>() / (cells * cells) as f32
    };
    let texels = (0..SIZE * SIZE).map(mean).collect();
    Some(Relief::new(&HeightMap { width: SIZE, height: SIZE, texels }, depth))
}

fn reliefs() -> Vec<(&'static str, Relief, Bounds)> {
    let relief = |map: &HeightMap| Relief::new(map, 1.0);
    let bounds = |shares, lit, sky, bounces, lean| Bounds { shares, lit, sky, bounces, lean };
    let scans = [
        ("walkway", scan("MetalWalkway006", 0.01), bounds(0.03, 0.03, 0.02, 0.015, 3.0)),
        ("sheet metal", scan("SheetMetal001", 0.01), bounds(0.02, 0.05, 0.03, 0.015, 3.0)),
        ("leather", scan("Leather027", 0.015), bounds(0.02, 0.03, 0.03, 0.02, 3.0)),
    ];
    let mut all = vec![
        ("studs", relief(&studs(SIZE, 9.0, 4.0, 0.5, 6.0)), bounds(0.03, 0.02, 0.02, 0.013, 3.0)),
        ("low studs", relief(&studs(SIZE, 14.0, 10.0, 0.35, 6.0)), bounds(0.02, 0.01, 0.01, 0.01, 2.0)),
        ("dense studs", relief(&studs(SIZE, 5.0, 6.0, 0.9, 6.0)), bounds(0.02, 0.01, 0.02, 0.01, 3.0)),
        ("bricks", relief(&bricks(SIZE)), bounds(0.03, 0.04, 0.03, 0.01, 3.0)),
        ("grooves", relief(&grooves(SIZE)), bounds(0.05, 0.13, 0.03, 0.035, 4.0)),
        ("tiles", relief(&tiles(SIZE)), bounds(0.03, 0.07, 0.03, 0.013, 3.0)),
        ("noise", Relief::noise(SIZE, 0.5), bounds(1e-9, 0.01, 0.015, 0.01, 2.0)),
    ];
    all.extend(scans.into_iter().filter_map(|(name, relief, bounds)| Some((name, relief?, bounds))));
    all
}

/// Returns one class with the moments of all facets.
fn joined(classes: &[Class]) -> Class {
    let mut one = Class { share: 1.0, mean: DVec2::ZERO, covariance: DVec3::ZERO, height: 0.0, height_variance: 1.0 };
    for class in classes {
        let m = class.mean;
        one.mean += class.share * m;
        one.covariance += class.share * (class.covariance + DVec3::new(m.x * m.x, m.y * m.y, m.x * m.y));
    }
    let m = one.mean;
    one.covariance -= DVec3::new(m.x * m.x, m.y * m.y, m.x * m.y);
    one
}

fn patch(relief: &Relief) -> Patch<'_> {
    Patch::new(&relief.tile, DVec2::ZERO, relief.tile.covariance())
}

fn shares(areas: [f64; MOST_CLASSES]) -> [f64; MOST_CLASSES] {
    let whole: f64 = areas.iter().sum();
    areas.map(|area| area / whole)
}

/// The lights, as elevations and azimuths from the viewer in degrees.
const LIGHTS: [(f64, f64); 9] = [
    (30.0, 0.0),
    (30.0, 70.0),
    (30.0, 180.0),
    (60.0, 0.0),
    (60.0, 17.0),
    (60.0, 70.0),
    (60.0, 180.0),
    (75.0, 0.0),
    (75.0, 115.0),
];

#[test]
fn shares_and_light_of_reliefs() {
    println!("relief: classes; visible shares, by lobes alone; lit fraction, of one class; largest, of one class");
    let mut faults = String::new();
    for (name, relief, bounds) in reliefs() {
        let one = joined(&relief.classes);
        let cholesky = slope_cholesky(one.covariance);
        let seen = |w| ClassesSeen { open: relief.openness(w), whitened: whitened_direction(w, cholesky) };
        let correlation = relief.correlation();
        let patch = patch(&relief);
        // Sums of squares for classes and for one class, and the largest errors of light.
        let (mut of_shares, mut of_lit, mut largest, mut counts) = ([0.0; 2], [0.0; 2], [0.0f64; 2], [0.0; 2]);
        for (theta, phi) in
            [20.0, 45.0, 60.0, 75.0, 82.0].into_iter().flat_map(|t| [17.0, 109.0, 229.0].map(|p| (t, p)))
        {
            let wo = direction(theta, phi);
            let lights = LIGHTS.map(|(theta, off)| direction(theta, phi + off));
            let e = patch.mean_over_visible(wo, 64, 1, |facet, _| {
                let class = relief.class_of(facet);
                let mut out = [0.0; MOST_CLASSES + 2 * MOST_CLASSES * LIGHTS.len()];
                out[class] = 1.0;
                for (i, &wi) in lights.iter().enumerate() {
                    let light = facet.normal.dot(wi).max(0.0);
                    let at = MOST_CLASSES * (1 + 2 * i) + class;
                    out[at] = light;
                    out[at + MOST_CLASSES] = if light > 0.0 && patch.is_lit(facet, wi) { light } else { 0.0 };
                }
                out
            });
            let e = e.expect("an upward direction").mean;
            let o = seen(wo);
            let mut lobes = [0.0; MOST_CLASSES];
            for (lobe, class) in lobes.iter_mut().zip(&relief.classes) {
                *lobe = class.share * visible_area(wo, class.mean, class.covariance);
            }
            counts[0] += 1.0;
            for (sum, found) in of_shares.iter_mut().zip([o.visible_shares(wo, &relief.classes), shares(lobes)]) {
                *sum += found.iter().zip(&e).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            }
            for (i, &wi) in lights.iter().enumerate() {
                let facing = &e[MOST_CLASSES * (1 + 2 * i)..][..MOST_CLASSES];
                let lit = &e[MOST_CLASSES * (2 + 2 * i)..][..MOST_CLASSES];
                let whole: f64 = facing.iter().sum();
                let truth = lit.iter().sum::<f64>() / whole;
                let area = |w| direction_area(w, one.mean, cholesky);
                let of_one = lit_fraction(Shadowing::Correlated, &area(wo), &area(wi));
                let of_classes = o.lit_fractions(Shadowing::Correlated, correlation, &seen(wi));
                let of_classes = facing.iter().zip(of_classes).map(|(a, b)| a * b).sum::<f64>() / whole;
                counts[1] += 1.0;
                for (k, found) in [of_classes, of_one].into_iter().enumerate() {
                    of_lit[k] += (found - truth).powi(2);
                    largest[k] = largest[k].max((found - truth).abs());
                }
            }
        }
        let [by_classes, by_lobes] = of_shares.map(|sum| (sum / counts[0]).sqrt());
        let [lit, of_one] = of_lit.map(|sum| (sum / counts[1]).sqrt());
        println!(
            "{name}: {}; {by_classes:.3}, {by_lobes:.3}; {lit:.3}, {of_one:.3}; {:.3}, {:.3}",
            relief.classes.len(),
            largest[0],
            largest[1]
        );
        if by_classes > bounds.shares || lit > bounds.lit {
            faults += &format!("{name}: {by_classes:.3} of {}, {lit:.3} of {}\n", bounds.shares, bounds.lit);
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// The radiance of the model: its single bounce of a sky, and what the other facets add for a radiosity of 1.
struct Reflected {
    sky: f64,
    by_facets: f64,
}

fn reflected(relief: &Relief, wo: DVec3, albedo: f64) -> Reflected {
    let sky = SkySeen::new(relief, wo);
    let shares = visible_shares(relief, wo);
    let mut reflected = Reflected { sky: 0.0, by_facets: 0.0 };
    for (k, share) in shares.into_iter().enumerate().take(relief.classes.len()) {
        let lit: Vec<f64> = sky.lit.iter().map(|lit| lit[k]).collect();
        let seen = sky_seen(&sky.visible[k], sky.up, &sky.directions, &lit);
        reflected.sky += albedo * share * seen;
        reflected.by_facets += albedo * share * (1.0 - seen);
    }
    reflected
}

/// The directions of the sky that the visible facets of each class see.
struct SkySeen {
    up: DVec3,
    visible: Vec<NormalMoments>,
    directions: Vec<DVec3>,
    lit: Vec<[f64; MOST_CLASSES]>,
}

impl SkySeen {
    fn new(relief: &Relief, wo: DVec3) -> Self {
        let one = joined(&relief.classes);
        let cholesky = slope_cholesky(one.covariance);
        let seen = |w: DVec3| ClassesSeen { open: relief.openness(w), whitened: whitened_direction(w, cholesky) };
        let up = normal_of_slope(one.mean);
        let frame = sky_frame(up, wo);
        let directions: Vec<DVec3> = (0..SKY_DIRECTIONS).map(|i| from_frame(&frame, sky_direction(i))).collect();
        let lit = |w: &DVec3| seen(wo).lit_fractions(Shadowing::CorrelatedSimple, relief.correlation(), &seen(*w));
        let visible = |class: &Class| visible_diffuse_moments(wo, class.mean, class.covariance, 2);
        Self {
            up,
            visible: relief.classes.iter().map(visible).collect(),
            lit: directions.iter().map(lit).collect(),
            directions,
        }
    }
}

fn visible_shares(relief: &Relief, wo: DVec3) -> [f64; MOST_CLASSES] {
    ClassesSeen { open: relief.openness(wo), whitened: DVec2::ZERO }.visible_shares(wo, &relief.classes)
}

/// Paths of up to eight bounces agree with the closed form, under a sky and under suns.
#[test]
fn light_between_bumps_follows_paths() {
    println!(
        "relief, albedo: missed by one bounce under a sky, error of it (10°, 45°, 75°); all bounces; suns, mean (rms)"
    );
    let mut faults = String::new();
    for (name, relief, bounds) in reliefs() {
        let sky = ClassSky::new(&relief.classes, relief.sky_depths());
        let patch = patch(&relief);
        for rho in [0.5, 0.9] {
            let bounces = ReliefBounces::new(&sky, &[DVec3::splat(rho); MOST_CLASSES]);
            let albedo = |_: &Facet| rho;
            let (mut missed, mut single, mut whole) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            let (mut sum, mut square, mut suns) = (0.0, 0.0, 0.0);
            for (i, theta) in [10.0, 45.0, 75.0].into_iter().enumerate() {
                let mut traced = [0.0; 2];
                let mut model = [0.0; 2];
                for phi in [29.0, 154.0, 260.0] {
                    let wo = direction(theta, phi);
                    let path = |facet: &Facet, random: &mut _| {
                        patch.traced_light(facet, albedo, (DVec3::Z, 0.0), |_| 1.0, 8, random)
                    };
                    let e = patch.mean_over_visible(wo, 160, 1, path).expect("an upward direction").mean;
                    let r = reflected(&relief, wo, rho);
                    let b = bounces.radiosity(DVec3::ONE, &sky.flux).x;
                    for (k, (truth, found)) in e.into_iter().zip([r.sky, r.sky + r.by_facets * b]).enumerate() {
                        traced[k] += truth;
                        model[k] += found;
                    }
                    for (high, off) in [(20.0, 0.0), (50.0, 0.0), (50.0, 90.0), (50.0, 180.0)] {
                        let wi = direction(high, phi + off);
                        let sun = |facet: &Facet, random: &mut _| {
                            patch.traced_light(facet, albedo, (wi, PI), |_| 0.0, 8, random)
                        };
                        let [direct, all] = patch.mean_over_visible(wo, 96, 2, sun).expect("an upward direction").mean;
                        let shares = visible_shares(&relief, wi);
                        let b = bounces.radiosity(DVec3::splat(meso_area(wi, sky.mean)), &shares).x;
                        // The model's direct light has errors of its own, so only the light of further bounces is compared.
                        let error = (r.by_facets * b - (all - direct)) / all;
                        (sum, square, suns) = (sum + error, square + error * error, suns + 1.0);
                    }
                }
                missed[i] = 100.0 * (1.0 - traced[0] / traced[1]);
                single[i] = 100.0 * (model[0] / traced[0] - 1.0);
                whole[i] = 100.0 * (model[1] / traced[1] - 1.0);
            }
            let (mean, rms) = (sum / suns, (square / suns).sqrt());
            println!(
                "{name}, {rho}: {missed:.1?}, {single:+.1?}; {whole:+.1?}; {:+.1} ({:.1})",
                100.0 * mean,
                100.0 * rms
            );
            let largest = |errors: [f64; 3]| errors.into_iter().fold(0.0f64, |a, e| a.max(0.01 * e.abs()));
            if largest(single) > bounds.sky || largest(whole) > bounds.sky || mean.abs() > bounds.bounces {
                faults += &format!("{name}, {rho}: {single:+.1?} {whole:+.1?} {mean:+.3}\n");
            }
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// The visible facets of a class receive light of a constant sky from about the same directions as in ray casts.
#[test]
fn environments_of_classes_lean_as_their_light_does() {
    let mut faults = String::new();
    for (name, relief, bounds) in reliefs() {
        let patch = patch(&relief);
        let (mut worst, mut all) = (0.0f64, 0.0);
        for (theta, phi) in [(20.0, 70.0), (45.0, 10.0), (60.0, 200.0), (75.0, 120.0)] {
            let wo = direction(theta, phi);
            let e = patch.mean_over_visible(wo, 96, 1, |facet, random| {
                let class = relief.class_of(facet);
                let mut out = [0.0; 4 * MOST_CLASSES];
                out[class] = 1.0;
                let w = patch.free_direction(facet, random);
                if let Some(w) = w {
                    out[MOST_CLASSES + 3 * class..][..3].copy_from_slice(&w.to_array());
                }
                out
            });
            let e = e.expect("an upward direction").mean;
            let sky = SkySeen::new(&relief, wo);
            for k in (0..relief.classes.len()).filter(|&k| e[k] > 0.05) {
                let mean = DVec3::from_slice(&e[MOST_CLASSES + 3 * k..][..3]).normalize();
                let light = sky.directions.iter().zip(&sky.lit).enumerate();
                let part = |(i, (w, lit)): (usize, (&DVec3, &[f64; MOST_CLASSES]))| {
                    sky_weight(i) * lit[k] * mean_cosine(&sky.visible[k], *w) * *w
                };
                let light: DVec3 = light.map(part).sum();
                let off = mean.dot(light.normalize()).clamp(-1.0, 1.0).acos().to_degrees();
                worst = worst.max(off);
                all += e[k] * off / 4.0;
            }
        }
        println!("{name}: {all:.1}° off in the mean, {worst:.1}° at most");
        if all > bounds.lean {
            faults += &format!("{name}: {all:.1}° {worst:.1}°\n");
        }
    }
    assert!(faults.is_empty(), "{faults}");
}
