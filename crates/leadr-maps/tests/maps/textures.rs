//! Tests of the textures that `leadr bake` writes for ordinary samplers: normals and gloss, heights from normals, occlusion
//! and cones.

use std::f64::consts::TAU;

use glam::DVec3;
use leadr_maps::bake::{DetailNormals, Inputs, Kind, Layout, Plan, PngFile, Precision, Roughness, Texels, bake};
use leadr_maps::baked::BakedMap;
use leadr_maps::material::{Encoding, GreenAxis, NormalMap, Raster, RoughnessMeaning, Samples, Texture};
use leadr_maps::{HeightMap, MapFault, Wrap};
use leadr_reflectance::facets::footprint_normals::{NormalTexel, mean_texel};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::{NormalArea, NormalFacets, Shortening};
use leadr_reflectance::slopes::normal_blending::{blend_partial_derivatives, blend_reoriented};

fn baked(inputs: &Inputs, kind: Kind, precision: Precision) -> BakedMap {
    crate::bake::baked(inputs, kind, precision).0
}

fn noise(x: u32, y: u32, seed: u32) -> f64 {
    let mut v = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed.wrapping_mul(0xc2b2_ae35);
    v = (v ^ (v >> 15)).wrapping_mul(0x2c1b_3c6d);
    v = (v ^ (v >> 12)).wrapping_mul(0x297a_2d39);
    f64::from(v ^ (v >> 15)) / f64::from(u32::MAX)
}

fn normal(x: u32, y: u32, seed: u32) -> DVec3 {
    DVec3::new(noise(x, y, seed) - 0.5, noise(x, y, seed + 1) - 0.5, 1.0).normalize()
}

fn normals(size: [u32; 2], of: impl Fn(u32, u32) -> DVec3) -> NormalMap {
    let texels = (0..size[0] * size[1]).flat_map(|i| {
        let n = of(i % size[0], i / size[0]);
        [n.x, n.y, n.z].map(|v| (0.5 * v + 0.5) as f32)
    });
    let raster = Raster::new(size[0], size[1], 3, Samples::F32(texels.collect())).unwrap();
    NormalMap { texture: Texture::new(raster, "normals", Encoding::Linear), green: GreenAxis::Up, scale: 1.0 }
}

fn gloss(size: [u32; 2], scale: Gloss, of: impl Fn(u32, u32) -> f64) -> Roughness {
    let texels = (0..size[0] * size[1]).map(|i| of(i % size[0], i / size[0]) as f32).collect();
    let raster = Raster::new(size[0], size[1], 1, Samples::F32(texels)).unwrap();
    Roughness { raster, channel: 0, meaning: RoughnessMeaning::Gloss(scale) }
}

fn texel(map: &BakedMap, level: usize, at: usize) -> [f64; 4] {
    map.levels[level].layers[0][at].map(f64::from)
}

#[test]
fn levels_of_gloss_are_means_of_shortened_normals() {
    for area in [NormalArea::Macro, NormalArea::Micro] {
        let size = [16, 8];
        let of = |x, y| 0.2 + 0.7 * noise(x, y, 9);
        let inputs = Inputs {
            normals: Some(normals(size, |x, y| normal(x, y, 1))),
            roughness: Some(gloss(size, Gloss::Wwii, of)),
            gloss: Gloss::Wwii,
            area,
            ..Inputs::default()
        };
        let map = baked(&inputs, Kind::Gloss, Precision::F32);
        assert_eq!(map.channels, ["N.x", "N.y", "N.z", "gloss"]);
        let shortening = Shortening { facets: NormalFacets::Ggx, area };
        let source = |x, y| NormalTexel { normal: normal(x, y, 1), alpha: Gloss::Wwii.alpha(of(x, y)) };
        for level in 0..4 {
            let side = 1 << level;
            for y in 0..8 / side {
                for x in 0..16 / side {
                    let below: Vec<_> =
                        (0..side * side).map(|i| source(x * side + i % side, y * side + i / side)).collect();
                    let expected = mean_texel(&below, shortening);
                    let [nx, ny, nz, g] = texel(&map, level as usize, (y * (16 / side) + x) as usize);
                    assert!((DVec3::new(nx, ny, nz) - expected.normal).length() < 1e-6, "{level} {x} {y}");
                    let found = Gloss::Wwii.gloss(expected.alpha);
                    assert!((g - found).abs() < 2e-5, "{area:?} {level} {x} {y}: {g} {found}");
                }
            }
        }
        // The finest level is stored as painted, and coarser levels are rougher.
        assert!((texel(&map, 0, 5)[3] - of(5, 0)).abs() < 2e-5);
        assert!(texel(&map, 4, 0)[3] < (0..128).map(|i| of(i % 16, i / 16)).sum::<f64>() / 128.0 - 0.05);
    }
}

#[test]
fn smooth_texels_are_rougher_where_normals_vary() {
    let size = [8, 8];
    let turning = normals(size, |x, _| DVec3::new(0.6 * (TAU * f64::from(x) / 8.0).sin(), 0.0, 1.0).normalize());
    let inputs = |texels| Inputs {
        normals: Some(turning.clone()),
        roughness: Some(gloss(size, Gloss::Wwii, |_, _| 0.9)),
        gloss: Gloss::Wwii,
        texels,
        ..Inputs::default()
    };
    let facets = baked(&inputs(Texels::Facets), Kind::Gloss, Precision::F32);
    let smooth = baked(&inputs(Texels::Smooth), Kind::Gloss, Precision::F32);
    // Normals change fastest at the zeros of the sine.
    for (x, least) in [(0, 0.2), (4, 0.2), (2, 0.05)] {
        let [a, b] = [&facets, &smooth].map(|map| texel(map, 0, 24 + x)[3]);
        assert!((a - 0.9).abs() < 1e-4 && b < a - least, "{x}: {a} {b}");
    }
}

#[test]
fn detail_rotates_with_the_surface() {
    let (size, fine) = ([4, 4], [8, 8]);
    for (blend, slopes) in [(blend_reoriented as fn(DVec3, DVec3) -> DVec3, false), (blend_partial_derivatives, true)] {
        let inputs = Inputs {
            normals: Some(normals(size, |x, y| normal(x, y, 3))),
            roughness: Some(gloss(size, Gloss::Wwii, |_, _| 0.4)),
            detail: Some(DetailNormals {
                normals: normals(fine, |x, y| normal(x, y, 5)),
                roughness: Some(gloss([2, 2], Gloss::Wwii, |_, _| 0.3)),
                repeat: 2,
                blend,
            }),
            gloss: Gloss::Wwii,
            ..Inputs::default()
        };
        let map = baked(&inputs, Kind::Gloss, Precision::F32);
        let both = Shortening::default().combine_gloss(0.4, 0.3, Gloss::Wwii);
        for (x, y) in [(0, 0), (1, 2), (3, 3)] {
            let [nx, ny, nz, g] = texel(&map, 0, (4 * y + x) as usize);
            // Two repeats over half as many texels read every fourth texel of the detail.
            let detail = normal((4 * x + 2) % 8, (4 * y + 2) % 8, 5);
            let expected = blend(normal(x, y, 3), detail);
            assert!((DVec3::new(nx, ny, nz) - expected).length() < 1e-5, "{x} {y} {expected}");
            assert!((g - both).abs() < 1e-4, "{g} {both}");
            if slopes {
                let sum = -normal(x, y, 3).x / normal(x, y, 3).z - detail.x / detail.z;
                assert!((-nx / nz - sum).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn normals_keep_their_length_and_any_size_works() {
    for size in [[1, 1], [1, 7], [13, 6], [5, 1]] {
        let inputs = Inputs { normals: Some(normals(size, |x, y| normal(x, y, 7))), ..Inputs::default() };
        for precision in [Precision::F32, Precision::F16, Precision::Bc] {
            let map = baked(&inputs, Kind::Normal, precision);
            for level in 0..map.levels.len() {
                for at in 0..map.levels[level].layers[0].len() {
                    let [x, y, z, _] = texel(&map, level, at);
                    let length = DVec3::new(x, y, z).length();
                    let most = if precision == Precision::Bc { 0.02 } else { 2e-3 };
                    assert!((length - 1.0).abs() < most, "{size:?} {precision:?} {level} {at}: {length}");
                }
            }
            let map = baked(&inputs, Kind::Gloss, precision);
            assert!(map.levels.iter().all(|level| level.layers[0].iter().all(|t| (-0.01..1.01).contains(&t[3]))));
        }
    }
    // Vectors that are zero, point down or are not unit length are invalid normals.
    let broken = normals([4, 4], |x, _| [DVec3::ZERO, DVec3::NEG_Z, DVec3::new(3.0, 0.0, 4.0), DVec3::X][x as usize]);
    let inputs = Inputs { normals: Some(broken), ..Inputs::default() };
    for kind in Kind::ALL {
        let mut inputs = inputs.clone();
        if matches!(kind, Kind::Height | Kind::Occlusion | Kind::Cones) {
            inputs.find_heights(&|_| ()).unwrap();
            inputs.compute_occlusion(&|_| ()).unwrap();
        }
        let map = baked(&inputs, kind, Precision::F32);
        assert!(map.levels.iter().flat_map(|l| &l.layers).flatten().flatten().all(|v| v.is_finite()), "{kind:?}");
    }
}

/// Returns waves that heights can represent exactly.
fn waves(n: u32) -> HeightMap {
    let at = |i: u32| (f64::from(i % n) / f64::from(n), f64::from(i / n) / f64::from(n));
    let height = |(s, t): (f64, f64)| 0.01 * (TAU * (2.0 * s + t)).sin() + 0.004 * (TAU * 5.0 * t).cos();
    HeightMap::new(n, n, (0..n * n).map(|i| height(at(i)) as f32).collect()).unwrap()
}

#[test]
fn heights_of_the_normals_of_heights_are_those_heights() {
    let n = 64;
    let map = waves(n);
    let step = |x: u32, y: u32, dx: i64, dy: i64| {
        let wrapped = |k: u32, d: i64| (i64::from(k) + d).rem_euclid(i64::from(n)) as u32;
        f64::from(map.at(wrapped(x, dx), wrapped(y, dy)))
    };
    let of = |x, y| {
        let per = 0.5 * f64::from(n);
        let [s, t] = [step(x, y, 1, 0) - step(x, y, -1, 0), step(x, y, 0, 1) - step(x, y, 0, -1)].map(|d| d * per);
        DVec3::new(-s, t, 1.0).normalize()
    };
    let mut inputs = Inputs { normals: Some(normals([n, n], of)), ..Inputs::default() };
    let found = inputs.find_heights(&|_| ()).unwrap();
    assert!(found.curl_share < 1e-3 && found.residual_rms < 0.02 * found.slope_rms, "{found}");
    let heights = baked(&inputs, Kind::Height, Precision::F32);
    assert_eq!((heights.channels[0].as_str(), heights.levels.len()), ("height", 7));
    let error: f64 = (0..(n * n) as usize).map(|i| (texel(&heights, 0, i)[0] - f64::from(map.texels[i])).powi(2)).sum();
    let size: f64 = map.texels.iter().map(|&h| f64::from(h).powi(2)).sum();
    assert!((error / size).sqrt() < 0.01, "{}", (error / size).sqrt());
    // Without normals, the function must fail.
    let fault = Inputs::default().find_heights(&|_| ()).unwrap_err();
    assert!(matches!(fault, MapFault::Unsupported { .. }) && fault.to_string().contains("normals"), "{fault}");
    assert!(Inputs::default().compute_occlusion(&|_| ()).is_err());
}

#[test]
fn flat_ground_sees_everything_and_pits_see_less() {
    let looked = |map: HeightMap| {
        let mut inputs =
            Inputs { heights: Some(map), height_scale: Some(1.0), wrap: Wrap::Repeat, ..Inputs::default() };
        inputs.compute_occlusion(&|_| ()).unwrap();
        inputs
    };
    let flat = looked(HeightMap::new(16, 16, vec![0.3; 256]).unwrap());
    let cones = baked(&flat, Kind::Cones, Precision::F32);
    for at in [0, 77, 255] {
        let [x, y, z, seen] = texel(&cones, 0, at);
        assert!(x.abs() + y.abs() < 1e-6 && (z - 1.0).abs() < 1e-6 && (seen - 1.0).abs() < 1e-6, "{x} {y} {z} {seen}");
    }
    // A groove along t is open up and down along t. The left side of the groove is open towards the right.
    let n = 64;
    let groove = |i: u32| 0.15 * (TAU * f64::from(i % n) / f64::from(n)).cos();
    let inputs = looked(HeightMap::new(n, n, (0..n * n).map(|i| groove(i) as f32).collect()).unwrap());
    let occlusion = baked(&inputs, Kind::Occlusion, Precision::F32);
    let cones = baked(&inputs, Kind::Cones, Precision::F32);
    let row = (10 * n) as usize;
    let [top, bottom] = [0, 32].map(|x| texel(&occlusion, 0, row + x)[0]);
    assert!(top > 0.97 && bottom < 0.85, "{top} {bottom}");
    let [left, right] = [22, 42].map(|x| texel(&cones, 0, row + x));
    assert!(left[0] > 0.1 && right[0] < -0.1 && (left[0] + right[0]).abs() < 1e-3, "{left:?} {right:?}");
    // With few slices, the results for up and down differ slightly.
    assert!(left[1].abs() < 5e-3, "{left:?}");
    // The last level is the mean of the finest level.
    let last = texel(&cones, cones.levels.len() - 1, 0);
    let mean = (0..(n * n) as usize).map(|i| texel(&cones, 0, i)[3]).sum::<f64>() / f64::from(n * n);
    assert!((last[3] - mean).abs() < 1e-5, "{last:?} {mean}");
}

#[test]
fn pictures_hold_the_finest_level() {
    use std::io::{Read, Seek};
    let inputs = Inputs { heights: Some(waves(16)), ..Inputs::default() };
    let plan = Plan::new(&inputs, Kind::Height, Layout::Leadr, Precision::F32).unwrap();
    let mut file = tempfile::tempfile().unwrap();
    let mut target = PngFile::new(&plan).unwrap();
    let report = bake(&inputs, &plan, &mut target, &|_| ()).unwrap();
    target.finish(&mut file, &report).unwrap();
    let mut bytes = Vec::new();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    let read = leadr_maps::decode_height_map(&bytes).unwrap();
    let [low, high] = report.height_range;
    for (code, height) in read.texels.iter().zip(&waves(16).texels) {
        let found = low + f64::from(*code) * (high - low);
        assert!((found - f64::from(*height)).abs() < 1e-6, "{found} {height}");
    }
    assert!(!PngFile::holds(Kind::Leadr) && PngFile::holds(Kind::Cones));
}
