//! Compares the wgpu picture with the equations in `f64`, pixel by pixel.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use leadr_maps::bake::{Inputs, Kind, Ktx2File, Layout, Plan, Precision, Roughness, bake};
use leadr_maps::baked::{BakedLevel, BakedMap};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{MaterialFolder, Role, RoughnessMeaning};
use leadr_maps::{load_height_map, load_raster};
use leadr_reflectance::frame::{Frame, from_frame};
use leadr_reflectance::integrals::sh::{Sh9, sh_radiance};
use leadr_reflectance::shading::{self, Surface};
use leadr_reflectance::slopes::map::{map_covariance, map_mean_slope, slope_map};
use leadr_reflectance::slopes::statistics::{covariance_from_moments, scale_height};
use leadr_wgpu::baked::Baked;
use leadr_wgpu::picture::{Picture, draw};
use leadr_wgpu::view::View;

const SIZE: [u32; 2] = [96, 64];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Filters the bricks of `assets/` with `leadr bake`.
fn baked(precision: Precision) -> (tempfile::TempDir, PathBuf) {
    let material = MaterialFolder::open(root().join("assets/bricks"), OutsideLinks::Refused).unwrap();
    let picture = |role| material.picture(role).unwrap();
    let roughness = load_raster(picture(Role::Roughness)).unwrap();
    let inputs = Inputs {
        heights: Some(load_height_map(picture(Role::Height)).unwrap()),
        normals: material.load().unwrap().normal_map,
        roughness: Some(Roughness { raster: roughness, channel: 0, meaning: RoughnessMeaning::Perceptual }),
        color: Some(load_raster(picture(Role::Color)).unwrap()),
        ..Inputs::default()
    };
    let plan = Plan::new(&inputs, Kind::Leadr, Layout::Leadr, precision).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("bricks.ktx2");
    let mut file = std::fs::File::create(&name).unwrap();
    let mut target = Ktx2File::new(&mut file, &plan).unwrap();
    let report = bake(&inputs, &plan, &mut target, &|_| ()).unwrap();
    target.finish(&report).unwrap();
    (folder, name)
}

fn drawn(file: &Path, view: &View) -> Picture {
    draw(&Baked::load(file).unwrap(), view, &root().join("shaders-glsl")).unwrap()
}

/// Returns a bilinear sample of a repeating level.
fn bilinear(level: &BakedLevel, at: DVec2) -> [[f64; 4]; 3] {
    let size = [level.width, level.height];
    let p = at * DVec2::new(f64::from(size[0]), f64::from(size[1])) - 0.5;
    let (cell, part) = (p.floor(), p - p.floor());
    let texel = |x: f64, y: f64| {
        let [x, y] = [x.rem_euclid(f64::from(size[0])) as usize, y.rem_euclid(f64::from(size[1])) as usize];
        let index = y * size[0] as usize + x;
        [0, 1, 2].map(|layer: usize| level.layers[layer][index].map(f64::from))
    };
    let mut sum = [[0.0; 4]; 3];
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let weight = (1.0 - dx + (2.0 * dx - 1.0) * part.x) * (1.0 - dy + (2.0 * dy - 1.0) * part.y);
        let texel = texel(cell.x + dx, cell.y + dy);
        sum.as_flattened_mut().iter_mut().zip(texel.as_flattened()).for_each(|(s, t)| *s += weight * t);
    }
    sum
}

/// Returns the means of the map over a pixel, as in `plane.frag`.
fn footprint(map: &BakedMap, texcoord: DVec2, ds: DVec2, dt: DVec2) -> [[f64; 4]; 3] {
    const TAPS: u32 = 16;
    let [width, height] = [map.levels[0].width, map.levels[0].height].map(f64::from);
    let size = DVec2::new(width, height);
    let (longer, shorter) = if ds.length() > dt.length() { (ds, dt) } else { (dt, ds) };
    let texels = ((longer * size).length() / f64::from(TAPS)).max((shorter * size).length()).max(1.0);
    let lod = texels.log2().min((map.levels.len() - 1) as f64);
    let (level, part) = (lod.floor() as usize, lod.fract());
    let mut sum = [[0.0; 4]; 3];
    for i in 0..TAPS {
        let at = texcoord + longer * ((f64::from(i) + 0.5) / f64::from(TAPS) - 0.5);
        for (level, weight) in [(level, 1.0 - part), ((level + 1).min(map.levels.len() - 1), part)] {
            let texel = bilinear(&map.levels[level], at);
            let weight = weight / f64::from(TAPS);
            sum.as_flattened_mut().iter_mut().zip(texel.as_flattened()).for_each(|(s, t)| *s += weight * t);
        }
    }
    sum
}

/// Returns the radiance of a pixel by `leadr_reflectance::shading`. `relief` is a factor on the slopes, which is 1 for the slopes of the
/// picture.
fn shaded(map: &BakedMap, view: &View, pixel: [u32; 2], relief: f64) -> DVec3 {
    let [corner, across, down] = view.rays().map(|ray| ray.as_dvec3());
    let (eye, sky) = (view.eye.as_dvec3(), view.sky.map(|c| c.as_dvec3()));
    let ray = corner + across * f64::from(pixel[0]) + down * f64::from(pixel[1]);
    let blurred = |c: &Sh9, d: DVec3, variance: f64| sh_radiance(c, d.normalize() * (-variance).exp()).max(DVec3::ZERO);
    if ray.z > -1e-4 {
        return blurred(&sky, ray, 0.0);
    }
    let per_metre = DVec2::new(1.0, -1.0) / f64::from(view.repeat);
    let back = -eye.z / ray.z;
    let texcoord = per_metre * (eye.truncate() + back * ray.truncate());
    let moved = |by: DVec3| per_metre * (back * (by.truncate() - ray.truncate() * (by.z / ray.z)));
    let [first, second, color] = footprint(map, texcoord, moved(across), moved(down));
    let frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    let slopes = slope_map(frame.x / per_metre.x, frame.y / per_metre.y, frame.x, frame.y, frame.z);
    let scale = f64::from(view.height_scale) * relief;
    let mean = DVec2::new(first[0], first[1]);
    let covariance = covariance_from_moments(mean, DVec3::new(first[2], first[3], second[0]));
    let surface = Surface {
        mean_slope: map_mean_slope(&slopes, scale * mean),
        slope_covariance: map_covariance(&slopes, scale_height(covariance, scale)),
        roughness: second[2].max(0.0).sqrt(),
        albedo: DVec3::new(color[0], color[1], color[2]),
        f0: DVec3::splat(0.04),
    };
    let wo = -ray.normalize();
    let lit = view.irradiance.as_dvec3() * shading::light(&surface, wo, view.sun.as_dvec3());
    let lookup = |d: DVec3, variance: f64| blurred(&sky, d, variance);
    debug_assert_eq!(from_frame(&frame, wo), wo);
    lit + shading::environment(&surface, wo, &frame, &sky, lookup)
}

/// Returns the largest channel difference between a picture and the equations, and its pixel. The difference is divided by the expected
/// radiance, or by 1 if the radiance is smaller.
fn worst(picture: &Picture, map: &BakedMap, view: &View, relief: f64) -> (f64, [u32; 2]) {
    let mut worst = (0.0, [0; 2]);
    for (i, seen) in (0u32..).zip(&picture.pixels) {
        let pixel = [i % picture.size[0], i / picture.size[0]];
        let expected = shaded(map, view, pixel, relief);
        let error = (0..3).map(|c| (f64::from(seen[c]) - expected[c]).abs() / expected[c].max(1.0)).fold(0.0, f64::max);
        if error > worst.0 || error.is_nan() {
            worst = (error, pixel);
        }
    }
    worst
}

#[test]
fn pixels_match_the_closed_form() {
    let (_folder, file) = baked(Precision::F32);
    let map = BakedMap::load(&file).unwrap();
    let view = View::morning(SIZE);
    let picture = drawn(&file, &view);
    let (error, pixel) = worst(&picture, &map, &view, 1.0);
    println!("f32: {error:.2e} at {pixel:?}");
    assert!(error < 1e-3, "{error} at {pixel:?}");

    // The picture shows the sky above, light and shade below, and depends on the relief.
    let row = |y: u32| &picture.pixels[(y * SIZE[0]) as usize..((y + 1) * SIZE[0]) as usize];
    let spread = |pixels: &[[f32; 4]]| {
        let (low, high) = pixels.iter().fold((f32::MAX, f32::MIN), |(l, h), p| (l.min(p[1]), h.max(p[1])));
        high / low
    };
    assert!(spread(row(SIZE[1] - 3)) > 2.0 * spread(row(1)), "no relief is seen");
    let (error, _) = worst(&picture, &map, &view, 1.05);
    assert!(error > 1e-2, "5 % of the slopes do not show: {error}");
}

#[test]
fn files_of_16_bits_are_read() {
    let (_folder, file) = baked(Precision::F16);
    let map = BakedMap::load(&file).unwrap();
    let view = View::morning(SIZE);
    let (error, pixel) = worst(&drawn(&file, &view), &map, &view, 1.0);
    println!("f16: {error:.2e} at {pixel:?}");
    assert!(error < 2e-3, "{error} at {pixel:?}");
}

#[test]
fn other_files_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.ktx2");
    std::fs::write(&file, b"nothing").unwrap();
    let error = Baked::load(&file).unwrap_err();
    assert!(error.contains("a.ktx2") && error.contains("KTX2"), "{error}");
    let (_folder, file) = baked(Precision::F16);
    let bytes = std::fs::read(&file).unwrap();
    for length in [0, 11, 79, 200, bytes.len() / 2, bytes.len() - 1] {
        assert!(Baked::decode(&bytes[..length]).is_err(), "{length} bytes");
    }
}
