use super::*;
use crate::{LeadrMap, procedural};

const SIDE: u32 = 128;

/// Returns a map rounded to multiples of 1/255.
fn rounded(map: &HeightMap) -> HeightMap {
    let texels = map.texels.iter().map(|h| (h * 255.0).round() / 255.0).collect();
    HeightMap::new(map.width, map.height, texels).unwrap()
}

fn made(f: impl Fn(f32, f32) -> f32) -> HeightMap {
    let unit = |i: u32| (i as f32 + 0.5) / SIDE as f32;
    let texels = (0..SIDE * SIDE).map(|i| f(unit(i % SIDE), unit(i / SIDE))).collect();
    HeightMap::new(SIDE, SIDE, texels).unwrap()
}

/// Returns waves with an amplitude in codes.
fn waves(amplitude: f32) -> HeightMap {
    let turn = std::f32::consts::TAU;
    made(|x, y| {
        let wave = (turn * (2.0 * x + 0.3 * (turn * y).sin())).sin() + 0.5 * (turn * (x + 3.0 * y)).sin();
        0.5 + amplitude / 255.0 * wave
    })
}

fn scaled(map: &HeightMap, factor: f32) -> HeightMap {
    let texels = map.texels.iter().map(|h| 0.2 + factor * h).collect();
    HeightMap::new(map.width, map.height, texels).unwrap()
}

/// Returns the slope variance of a map along both axes.
fn variance(map: &HeightMap) -> f64 {
    let [xx, yy, _] = LeadrMap::new(map, Wrap::Repeat).mean().slope_covariance();
    xx + yy
}

fn rms(a: &HeightMap, b: &HeightMap) -> f64 {
    let sum: f64 = a.texels.iter().zip(&b.texels).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.texels.len() as f64).sqrt()
}

fn restored(map: &HeightMap) -> (HeightMap, Quantisation) {
    let mut map = map.clone();
    let found = restore(&mut map, Wrap::Repeat).expect("a coarse map");
    (map, found)
}

/// Returns `map` moved down and to the right by half its side.
fn moved(map: &HeightMap) -> HeightMap {
    let half = |i: u32| (i + SIDE / 2) % SIDE;
    let texels = (0..SIDE * SIDE).map(|i| map.at(half(i % SIDE), half(i / SIDE))).collect();
    HeightMap::new(SIDE, SIDE, texels).unwrap()
}

/// Returns bricks 150 codes high with flat faces, between flat joints that are clipped at 0.
fn bricks() -> HeightMap {
    made(|x, y| if (4.0 * x).fract() < 0.1 || (8.0 * y).fract() < 0.2 { 0.0 } else { 150.0 / 255.0 })
}

/// Reliefs with the largest ratio of RMS errors of restored and raw heights that each may have.
fn reliefs() -> Vec<(String, HeightMap, f64)> {
    let mut all: Vec<_> = [(40.0, 0.5), (10.0, 0.25), (3.0, 0.25)]
        .map(|(codes, most)| (format!("waves of {codes} codes"), waves(codes), most))
        .into();
    for factor in [1.0, 0.3, 0.1] {
        all.push((format!("rock times {factor}"), scaled(&procedural::rock(SIDE, SIDE, 3), 0.7 * factor), 1.001));
        all.push((format!("soil times {factor}"), scaled(&procedural::soil(SIDE, SIDE, 4), 0.7 * factor), 1.001));
    }
    for slope in [1.0, 0.5, 0.25] {
        let noise = procedural::gaussian(SIDE, SIDE, 5, slope, 3.0 / SIDE as f32);
        all.push((format!("noise of slope {slope}"), scaled(&noise, 0.5), 0.8));
    }
    all
}

#[test]
fn slope_variances_and_heights_are_those_of_the_relief() {
    for (name, relief, most) in reliefs() {
        let raw = rounded(&relief);
        let (found, quantisation) = restored(&raw);
        let ratio = variance(&found) / variance(&relief);
        assert!((0.9..1.1).contains(&ratio), "{name}: the slope variance is {ratio} of the relief");
        let errors = rms(&found, &relief) / rms(&raw, &relief);
        assert!(errors < most, "{name}: the heights have {errors} of the error");
        // Where rounding makes much of the variance, its share is known.
        let share = 1.0 - variance(&relief) / variance(&raw);
        assert!((quantisation.before - share).abs() < 0.07, "{name}: {quantisation:?}, but rounding made {share}");
    }
}

#[test]
fn the_spread_inside_footprints_is_that_of_the_relief() {
    let inside = |map: &HeightMap, level: usize| -> f64 {
        let texels = &LeadrMap::new(map, Wrap::Repeat).levels[level].texels;
        texels.iter().map(|texel| texel.slope_covariance()[..2].iter().sum::<f64>()).sum::<f64>() / texels.len() as f64
    };
    let relief = waves(10.0);
    let (raw, (found, _)) = (rounded(&relief), restored(&rounded(&relief)));
    for level in 2..=7 {
        let [raw, found] = [&raw, &found].map(|map| inside(map, level) / inside(&relief, level));
        assert!((0.9..1.1).contains(&found) && raw > 1.2, "level {level}: {raw} becomes {found}");
    }
}

#[test]
fn noise_of_a_code_is_not_smoothed_away() {
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    for deviation in [0.4, 0.8, 1.6] {
        let mut relief = waves(20.0);
        for h in &mut relief.texels {
            let normal: f32 = (0..12).map(|_| random()).sum::<f32>() - 6.0;
            *h += deviation / 255.0 * normal;
        }
        let ratio = variance(&restored(&rounded(&relief)).0) / variance(&relief);
        assert!((0.9..1.1).contains(&ratio), "noise of {deviation} codes: {ratio}");
    }
}

#[test]
fn heights_stay_within_half_a_code_and_within_the_container() {
    for (name, relief, _) in reliefs() {
        let raw = rounded(&scaled(&relief, 1.3));
        let clipped = raw.texels.iter().map(|h| h.clamp(0.0, 1.0)).collect();
        let raw = HeightMap::new(SIDE, SIDE, clipped).unwrap();
        let (found, _) = restored(&raw);
        for (h, code) in found.texels.iter().zip(&raw.texels) {
            assert!((h - code).abs() <= 0.5 / 255.0 + 1e-6 && (0.0..=1.0).contains(h), "{name}: {code} becomes {h}");
        }
    }
}

#[test]
fn restored_heights_and_fine_maps_stay_bit_for_bit() {
    let (found, _) = restored(&rounded(&waves(10.0)));
    let sixteen_bits = scaled(&procedural::rock(SIDE, SIDE, 3), 0.3).texels.into_iter();
    let sixteen_bits = sixteen_bits.map(|h| (h * 65535.0).round() / 65535.0).collect();
    let slopes = made(|x, y| 3.0 * x - y);
    for map in [found, HeightMap::new(SIDE, SIDE, sixteen_bits).unwrap(), slopes] {
        let mut again = map.clone();
        assert_eq!(restore(&mut again, Wrap::Repeat), None);
        assert!(again == map);
    }
}

#[test]
fn edges_between_flat_areas_and_masks_stay_bit_for_bit() {
    let checker = made(|x, y| f32::from(u8::from((16.0 * x).fract() < 0.5) ^ u8::from((16.0 * y).fract() < 0.5)));
    for map in [bricks(), checker, rounded(&made(|_, _| 0.37))] {
        let mut same = map.clone();
        assert_eq!(restore(&mut same, Wrap::Repeat), None);
        assert!(same == map);
    }
}

#[test]
fn edges_stay_between_gentle_faces() {
    let gentle = waves(4.0);
    let mut relief = bricks();
    relief.texels.iter_mut().zip(&gentle.texels).for_each(|(h, g)| *h += g - 0.3);
    let raw = rounded(&relief);
    let (found, _) = restored(&raw);
    assert!(rms(&found, &relief) < 0.8 * rms(&raw, &relief), "{} {}", rms(&found, &relief), rms(&raw, &relief));
    assert!((variance(&found) / variance(&relief) - 1.0).abs() < 0.01);
}

#[test]
fn clipped_areas_stay_flat() {
    let raw = rounded(&made(|x, _| ((x * std::f32::consts::TAU).sin() * 40.0 / 255.0).max(0.0)));
    let (found, _) = restored(&raw);
    let flat = (SIDE / 2 + 4..SIDE - 4).flat_map(|x| (0..SIDE).map(move |y| (x, y)));
    flat.for_each(|(x, y)| assert_eq!(found.at(x, y), 0.0, "at {x}, {y}"));
}

#[test]
fn codes_of_every_container_are_found() {
    let relief = waves(10.0);
    let with =
        |of: &dyn Fn(f32) -> f32| HeightMap::new(SIDE, SIDE, relief.texels.iter().map(|&h| of(h)).collect()).unwrap();
    let half = |h: f32| half::f16::from_f32((h * 255.0).round() / 255.0).to_f32();
    let repeated = |bits: i32| {
        move |h: f32| {
            let code = (h * ((1 << bits) - 1) as f32).round() as u32;
            ((code << (16 - bits)) | (code >> (2 * bits - 16))) as f32 / 65535.0
        }
    };
    for (name, map, step) in [
        ("8 bits", with(&|h| (h * 255.0).round() / 255.0), 1.0 / 255.0),
        ("high byte of 16 bits", with(&|h| (h * 255.0).round() * 256.0 / 65535.0), 256.0 / 65535.0),
        ("half floats", with(&half), 1.0 / 255.0),
        ("10 bits", with(&repeated(10)), 1.0 / 1023.0),
        ("high 10 bits of 16", with(&|h| (h * 1023.0).round() * 64.0 / 65535.0), 64.0 / 65535.0),
        ("12 bits", with(&repeated(12)), 1.0 / 4095.0),
        ("whole metres", with(&|h| (h * 500.0).round()), 1.0),
    ] {
        let (found, quantisation) = restored(&map);
        assert!((quantisation.step - step).abs() < 1e-6 * step, "{name}: {quantisation:?}");
        assert!(variance(&found) < variance(&map), "{name}");
    }
    let labels = with(&|h| (h * 8.0).round());
    assert_eq!(restore(&mut labels.clone(), Wrap::Repeat), None);
}

#[test]
fn the_result_does_not_depend_on_threads_and_repeats() {
    let raw = rounded(&waves(10.0));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| restored(&raw))
    };
    let (found, quantisation) = with(1);
    assert!(with(3) == (found.clone(), quantisation));
    assert!(restored(&moved(&raw)).0 == moved(&found));
}

#[test]
fn maps_that_end_and_small_maps_are_restored() {
    let raw = rounded(&made(|x, y| 0.1 * x + 0.03 * y));
    let mut ends = raw.clone();
    restore(&mut ends, Wrap::Clamp).unwrap();
    let slope = |x: u32| ends.at(x + 1, 64) - ends.at(x, 64);
    [10, 60, 117].iter().for_each(|&x| assert!((slope(x) * SIDE as f32 - 0.1).abs() < 0.01, "at {x}: {}", slope(x)));
    for (width, height) in [(1, 1), (1, 9), (2, 2), (3, 1), (5, 17)] {
        let texels = (0..width * height).map(|i| (i % 3) as f32 / 255.0).collect();
        let raw = HeightMap::new(width, height, texels).unwrap();
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let mut found = raw.clone();
            restore(&mut found, wrap);
            let apart = found.texels.iter().zip(&raw.texels).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart <= 0.5 / 255.0 + 1e-6, "{width} x {height}: {apart}");
        }
    }
}
