//! The environment cube against its sources: the 64-bit analytic sky, panoramas of known radiance, and its own mips.

use std::f64::consts::PI;

use glam::DVec3;
use leadr::gpu::{AddressMode, Descriptor, Filter, Sampler};
use leadr::maps::RgbImage;
use leadr::reflectance::visible::kernel::{kernel_levels, kernel_variance};
use leadr::render::light::environment::Environment;
use leadr::render::light::panorama::LightExtraction;
use leadr::render::light::sky::Sky;
use leadr_testing::cube::{panorama, read_image_level, read_level};
use leadr_testing::gpu::{run_probe_with, test_gpu};

/// Radiance integrated over the sphere, and its mean direction.
fn power(texels: &[(DVec3, f64, DVec3)]) -> (DVec3, DVec3) {
    let sum = texels.iter().fold(DVec3::ZERO, |sum, (_, w, l)| sum + *w * *l);
    let centre = texels.iter().fold(DVec3::ZERO, |sum, (d, w, l)| sum + *w * l.y * *d);
    (sum, centre.normalize_or_zero())
}

fn relative(a: DVec3, b: DVec3) -> f64 {
    ((a - b).abs() / (a.abs() + b.abs()).max(DVec3::splat(1e-6)) * 2.0).max_element()
}

#[test]
fn the_sky_matches_its_64_bit_evaluation() {
    let Some(gpu) = test_gpu() else { return };
    let suns = [(85.0f32, 0.3f32, 2.2f32), (35.0, 2.5, 1.0), (5.0, -2.0, 6.0), (-2.0, 1.0, 2.2), (90.0, 0.0, 3.0)];
    let mut environment = Environment::from_sky(&gpu, 64, &Sky::default()).unwrap();
    for (elevation, azimuth, turbidity) in suns {
        let sky = Sky { turbidity, ..Sky::with_sun(elevation.to_radians(), azimuth) };
        assert!(gpu.submit("sky", |cmd| environment.update_sky(cmd, &sky)).unwrap());
        let tables = sky.tables();
        let mut worst = (0.0, DVec3::ZERO);
        // relative to the pixel and, where it is dark, to a thousandth of the sky's mean
        let texels = read_level(&environment, 0);
        let floor = power(&texels).0 / (4.0 * PI) * 1e-3;
        for (d, _, l) in &texels {
            let expected = tables.radiance(*d);
            let error = ((*l - expected).abs() / (expected + floor)).max_element();
            if error > worst.0 {
                worst = (error, *d);
            }
        }
        println!(
            "sun at {elevation}°, turbidity {turbidity}: {} directions, worst {:.2e} at {:.3}",
            texels.len(),
            worst.0,
            worst.1
        );
        assert!(worst.0 < 2e-4, "{worst:?}");
        // the comparison can fail: moving the sun by a tenth of a degree is detected
        let moved = Sky { turbidity, ..Sky::with_sun((elevation + 0.1).to_radians(), azimuth + 0.01) }.tables();
        let moved_by = texels.iter().map(|(d, _, l)| relative(*l, moved.radiance(*d))).fold(0.0, f64::max);
        assert!(moved_by > 2.0 * worst.0, "{moved_by}");
    }
}

/// Whether texels are equal within the rounding of 16-bit floats and of texture coordinates, which blends a ten-thousandth of a texel.
fn same_as_halves(halves: &[(DVec3, f64, DVec3)], exact: &[(DVec3, f64, DVec3)]) -> bool {
    let brightest = exact.iter().map(|texel| texel.2.max_element()).fold(0.0, f64::max);
    let near = |(a, b): (f64, f64)| (a - b).abs() <= b.abs() / 2000.0 + 6e-8 + 1e-4 * brightest;
    halves.iter().zip(exact).all(|(a, b)| (0..3).all(|c| near((a.2[c], b.2[c]))))
}

#[test]
fn unchanged_sky_is_not_recomputed() {
    let Some(gpu) = test_gpu() else { return };
    let sky = Sky::with_sun(0.5, 1.0);
    let mut environment = Environment::from_sky(&gpu, 16, &sky).unwrap();
    let other = Sky::with_sun(0.51, 1.0);
    let recorded =
        gpu.submit("sky", |cmd| [sky, other, other, sky].map(|sky| environment.update_sky(cmd, &sky))).unwrap();
    assert_eq!(recorded, [false, true, false, true]);
}

#[test]
fn every_level_has_the_same_mean() {
    let Some(gpu) = test_gpu() else { return };
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::with_sun(0.4, 0.7)).unwrap();
    assert_eq!(environment.levels(), Environment::FACE_SIZE.ilog2() + 1);
    let (first, _) = power(&read_level(&environment, 0));
    let mut worst = 0.0f64;
    for mip in 1..environment.levels() {
        let error = relative(power(&read_level(&environment, mip)).0, first);
        println!("level {mip}: {error:.2e}");
        worst = worst.max(error);
    }
    println!("means of {} levels agree to {worst:.2e}", environment.levels());
    assert!(worst < 1e-5);
    // unweighted means differ, so the weights are tested
    let plain = |mip| {
        let texels = read_level(&environment, mip);
        texels.iter().fold(DVec3::ZERO, |sum, t| sum + t.2) / texels.len() as f64
    };
    assert!(relative(plain(0), first / (4.0 * PI)) > 1e-3);
}

/// Mip levels for probes: a bright pixel at any position is a spot of the same power, position and stated width at every level.
#[test]
fn every_blurred_level_has_the_power_and_width_it_claims() {
    let Some(gpu) = test_gpu() else { return };
    let size = Environment::FACE_SIZE;
    // At the centre of a face, on an edge, near a corner.
    for (column, row) in [(512u32, 256u32), (640, 256), (641, 158)] {
        let mut image = panorama(1024, |_| DVec3::ZERO);
        image.texels[(row * 1024 + column) as usize] = [1e5; 3];
        let none = LightExtraction { count: 0, ..Default::default() };
        let environment = Environment::from_panorama(&gpu, size, &image, none).unwrap();
        let finest = read_level(&environment, 0);
        assert!(same_as_halves(&read_image_level(environment.lobes(), 0), &finest));
        let (sum, centre) = power(&finest);
        for level in 1..kernel_levels(size) {
            let texels = read_image_level(environment.lobes(), level);
            let (blurred, middle) = power(&texels);
            // A kernel of variance v has the mean cosine exp(-v).
            let cosine = texels.iter().map(|(d, w, l)| w * l.y * d.dot(centre)).sum::<f64>() / blurred.y;
            let (variance, wanted) = (-cosine.ln(), kernel_variance(level, size));
            let off = middle.angle_between(centre) / wanted.sqrt();
            let [power, width] = [blurred.y / sum.y - 1.0, variance / wanted - 1.0];
            println!(
                "{column}, {row}, level {level}: power {power:+.1e}, variance {width:+.1e}, off by {off:.1e} deviations"
            );
            assert!(power.abs() < 0.05 && width.abs() < 0.05 && off < 0.06);
        }
    }
}

/// The sky has little detail, so its cube is smaller, with smooth kernels from fewer lookups. It matches that of its image.
#[test]
fn the_sky_blurs_like_a_picture_of_it() {
    let Some(gpu) = test_gpu() else { return };
    let size = Environment::FACE_SIZE;
    for elevation in [4.0f32, 40.0] {
        let sky = Sky::with_sun(elevation.to_radians(), 0.7);
        let tables = sky.tables();
        let picture = panorama(4 * size, |direction| tables.radiance(direction));
        let none = LightExtraction { count: 0, ..Default::default() };
        let [sky, picture] = [
            Environment::from_sky(&gpu, size, &sky).unwrap(),
            Environment::from_panorama(&gpu, size, &picture, none).unwrap(),
        ];
        let image = sky.lobes();
        let finer = size.ilog2() - image.desc().width.ilog2();
        assert!(finer > 0 && same_as_halves(&read_image_level(image, 0), &read_level(&sky, finer)));
        for level in 1..image.desc().mips {
            let ours = read_image_level(image, level);
            let theirs = read_image_level(picture.lobes(), level + finer);
            let mean = power(&theirs).0.y / (4.0 * PI);
            let brightest = theirs.iter().map(|(_, _, l)| l.y).fold(0.0, f64::max);
            let [mut square, mut worst] = [0.0, 0.0f64];
            for ((_, weight, a), (_, _, b)) in ours.iter().zip(&theirs) {
                square += weight * ((a.y - b.y) / mean).powi(2) / (4.0 * PI);
                worst = worst.max((a.y - b.y).abs() / brightest);
            }
            let rms = square.sqrt();
            println!(
                "sun at {elevation}°, level {level}: rms {rms:.1e} of the mean, worst {worst:.1e} of the brightest"
            );
            assert!(rms < 5e-3 && worst < 0.01);
        }
    }
}

#[test]
fn panorama_arrives_in_the_documented_directions() {
    let Some(gpu) = test_gpu() else { return };
    let f = |d: DVec3| DVec3::new(1.5 + d.x, 1.5 + d.y, 1.5 + d.z) * (1.0 + 0.3 * (3.0 * d.x).sin());
    let environment = Environment::from_equirect(&gpu, 64, &panorama(512, f)).unwrap();
    let worst = read_level(&environment, 0).iter().map(|(d, _, l)| relative(*l, f(*d))).fold(0.0, f64::max);
    println!("panorama to cube texels: worst {worst:.2e}");
    assert!(worst < 2e-3);

    // a shader sampling the cube gets the same values, also on edges and corners
    let mut inputs = Vec::new();
    for i in 0..4000u32 {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
        let phi = f64::from(i) * PI * (3.0 - 5.0f64.sqrt());
        let r = (1.0 - z * z).sqrt();
        inputs.push([(r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32, 0.0]);
    }
    for i in 0..8u32 {
        inputs.push([[1.0, -1.0][i as usize & 1], [1.0, -1.0][i as usize >> 1 & 1], [1.0, -1.0][i as usize >> 2], 0.0]);
        inputs.push([[1.0, -1.0][i as usize & 1], [1.0, -1.0][i as usize >> 1 & 1], i as f32 / 4.0 - 1.0, 0.0]);
    }
    let sampler = Sampler::new(&gpu, Filter::Trilinear, AddressMode::ClampToEdge).unwrap();
    let cube = [("cube", Descriptor::Sampled(environment.cube(), &sampler))];
    let sampled = run_probe_with(&gpu, "probes/passes/cube_sample.comp", &inputs, 3, &[], &cube, &[]);
    let mut worst = 0.0f64;
    for (input, c) in inputs.iter().zip(sampled.chunks(3)) {
        let d = DVec3::new(input[0].into(), input[1].into(), input[2].into()).normalize();
        worst = worst.max(relative(DVec3::new(c[0].into(), c[1].into(), c[2].into()), f(d)));
    }
    println!("cube sampled in {} directions: worst {worst:.2e}", inputs.len());
    assert!(worst < 5e-3);
    // a mirrored image would differ much
    assert!(relative(f(DVec3::new(0.0, 0.8, 0.6)), f(DVec3::new(0.0, -0.8, 0.6))) > 0.1);
}

#[test]
fn one_pixel_sun_keeps_power_and_direction() {
    let Some(gpu) = test_gpu() else { return };
    // the row at the pole is 8 % too wide (the sampler does not filter across the pole), so it has its own bounds
    let mut worst = [(0.0f64, 0.0f64); 2];
    for (width, column, row) in [
        (1024u32, 300u32, 200u32),
        (1024, 0, 255),
        (1024, 511, 40),
        (1024, 700, 3),
        (1024, 129, 0),
        (4096, 1717, 933),
        (256, 3, 70),
    ] {
        let mut image = panorama(width, |_| DVec3::ZERO);
        let at = (row * width + column) as usize;
        image.texels[at] = [1e5, 2e5, 5e4];
        let (top, bottom) = (f64::from(row), f64::from(row + 1));
        let cos = |r: f64| (PI * r / f64::from(image.height)).cos();
        let exact = 2e5 * (cos(top) - cos(bottom)) * 2.0 * PI / f64::from(width);
        let (theta, phi) = (
            PI * (top + 0.5) / f64::from(image.height),
            2.0 * PI * (0.5 - (f64::from(column) + 0.5) / f64::from(width)),
        );
        let position = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let no_lights = LightExtraction { count: 0, ..Default::default() };
        let environment = Environment::from_panorama(&gpu, Environment::FACE_SIZE, &image, no_lights).unwrap();
        let (sum, centre) = power(&read_level(&environment, 0));
        let off = centre.angle_between(position).to_degrees();
        println!("{width} wide, pixel {column},{row}: power off by {:.2e}, place by {off:.3}°", sum.y / exact - 1.0);
        let worst = &mut worst[usize::from(row == 0)];
        *worst = (worst.0.max((sum.y / exact - 1.0).abs()), worst.1.max(off));
    }
    assert!(worst[0].0 < 0.015 && worst[0].1 < 0.1 && worst[1].0 < 0.11, "{worst:?}");
}

#[test]
fn faces_must_be_a_power_of_two() {
    let Some(gpu) = test_gpu() else { return };
    let error = Environment::from_sky(&gpu, 100, &Sky::default()).err().unwrap().to_string();
    assert!(error.contains("power of two"), "{error}");
}

/// Writes unwrapped, tone-mapped environments to `target/tmp/light` for inspection.
#[test]
#[ignore = "writes pictures"]
fn pictures() {
    let Some(gpu) = test_gpu() else { return };
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("light");
    std::fs::create_dir_all(&folder).unwrap();
    let (w, h) = (768u32, 384u32);
    let sampler = Sampler::new(&gpu, Filter::Trilinear, AddressMode::ClampToEdge).unwrap();
    let view = |environment: &Environment, lod: f32, exposure: f32, name: &str| {
        let directions = panorama(w, |d| d);
        let inputs: Vec<[f32; 4]> = directions.texels.iter().map(|d| [d[0], d[1], d[2], lod]).collect();
        let cube = [("cube", Descriptor::Sampled(environment.cube(), &sampler))];
        let sampled = run_probe_with(&gpu, "probes/passes/cube_sample.comp", &inputs, 3, &[], &cube, &[]);
        let image = RgbImage::new(w, h, sampled.chunks(3).map(|c| [c[0], c[1], c[2]]).collect()).unwrap();
        let shown = leadr::maps::tonemap::display_image(&image, exposure, leadr::maps::tonemap::Tonemap::Filmic);
        image::save_buffer(folder.join(name), shown.texels.as_flattened(), w, h, image::ColorType::Rgb8).unwrap();
        println!("{}", folder.join(name).display());
    };
    for elevation in [3.0f32, 20.0, 60.0] {
        let sky = Sky::with_sun(elevation.to_radians(), -0.8);
        let clock = std::time::Instant::now();
        let mut environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky).unwrap();
        println!("first sky {:?}", clock.elapsed());
        let other = Sky::with_sun(elevation.to_radians() + 1e-4, -0.8);
        let clock = std::time::Instant::now();
        gpu.submit("sky", |cmd| environment.update_sky(cmd, &other)).unwrap();
        println!("next sky {:?}", clock.elapsed());
        view(&environment, 0.0, 1.5, &format!("sky-{elevation}.png"));
    }
    if let Some(folder) = leadr_testing::shared::shared_data("env") {
        for name in ["spruit_sunrise_1k", "studio_pmndrs_1k"] {
            let file = folder.join(format!("{name}.hdr"));
            let image = leadr::maps::load_environment(file).unwrap();
            let clock = std::time::Instant::now();
            let environment = Environment::from_equirect(&gpu, Environment::FACE_SIZE, &image).unwrap();
            println!("panorama {:?}", clock.elapsed());
            view(&environment, 0.0, 1.0, &format!("{name}.png"));
            view(&environment, 4.0, 1.0, &format!("{name}-lod4.png"));
        }
    }
}

/// Prints the sky's time per frame, without validation.
#[test]
#[ignore = "measures time"]
fn timings() {
    let gpu = leadr::open_gpu(&leadr::gpu::GpuOptions::default()).unwrap();
    let mut environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::default()).unwrap();
    let irradiance = leadr::render::light::irradiance::IrradiancePass::new(&gpu).unwrap();
    let timestamps = leadr::gpu::Timestamps::new(&gpu, 4).unwrap();
    for frame in 1..8 {
        gpu.submit("frame", |cmd| {
            cmd.reset_timestamps(&timestamps);
            cmd.timestamp(&timestamps, "begin");
            environment.update_sky(cmd, &Sky::with_sun(0.1 * frame as f32, 0.0));
            cmd.timestamp(&timestamps, "sky and mips");
            irradiance.record(cmd, &environment);
            cmd.timestamp(&timestamps, "irradiance");
        })
        .unwrap();
        println!("{:.2?}", timestamps.intervals().unwrap());
    }
}
