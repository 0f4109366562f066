//! The irradiance pass against a 64-bit projection of the cube that it reads, and against closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use leadr::gpu::Gpu;
use leadr::reflectance::integrals::sh::{Sh9, sh_add_light, sh_basis, sh_irradiance};
use leadr::render::light::environment::Environment;
use leadr::render::light::irradiance::IrradiancePass;
use leadr::render::light::panorama::LightExtraction;
use leadr::render::light::sky::Sky;
use leadr_testing::cube::{panorama, read_image_level};
use leadr_testing::gpu::test_gpu;
use std::sync::Arc;

/// The 64-bit projection of a level: exact solid angles, basis at the texel centres.
fn project(environment: &Environment, mip: u32) -> Sh9 {
    let mut c = [DVec3::ZERO; 9];
    for (d, solid_angle, radiance) in leadr_testing::cube::read_level(environment, mip) {
        sh_add_light(&mut c, d, solid_angle * radiance);
    }
    c
}

fn run(gpu: &Arc<Gpu>, environment: &Environment) -> Vec<[f32; 4]> {
    let pass = IrradiancePass::new(gpu).unwrap();
    gpu.submit("irradiance", |cmd| pass.record(cmd, environment)).unwrap();
    pass.coefficients().read_all().unwrap()
}

fn sh(c: &[[f32; 4]]) -> Sh9 {
    std::array::from_fn(|k| DVec3::new(c[k][0].into(), c[k][1].into(), c[k][2].into()))
}

/// Largest difference relative to L00, which bounds all other coefficients of nonnegative radiance.
fn error(a: &Sh9, b: &Sh9) -> f64 {
    let scale = b[0].max(DVec3::splat(1e-12));
    a.iter().zip(b).map(|(a, b)| ((*a - *b) / scale).abs().max_element()).fold(0.0, f64::max)
}

#[test]
fn projection_matches_64_bits() {
    let Some(gpu) = test_gpu() else { return };
    let pass = IrradiancePass::new(&gpu).unwrap();
    for (elevation, face_size) in
        [(5.0f32, Environment::FACE_SIZE), (40.0, Environment::FACE_SIZE), (70.0, 64), (30.0, 8)]
    {
        let environment = Environment::from_sky(&gpu, face_size, &Sky::with_sun(elevation.to_radians(), 2.0)).unwrap();
        let gpu_result = sh(&run(&gpu, &environment));
        let level = pass.level(&environment);
        let same_level = error(&gpu_result, &project(&environment, level));
        let finest = error(&gpu_result, &project(&environment, 0));
        println!(
            "sun {elevation}°, {face_size}²: level {level} {same_level:.2e}, against the finest level {finest:.2e}"
        );
        assert!(same_level < 3e-6, "{same_level}");
        assert!(finest < 2e-3, "{finest}");
        // another sky must differ
        let other = Environment::from_sky(&gpu, face_size, &Sky::with_sun(elevation.to_radians(), 2.01)).unwrap();
        assert!(error(&gpu_result, &project(&other, level)) > 1e-4);
    }
}

#[test]
fn the_same_bytes_every_run() {
    let Some(gpu) = test_gpu() else { return };
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::default()).unwrap();
    let first = run(&gpu, &environment);
    for _ in 0..3 {
        assert_eq!(first, run(&gpu, &environment));
    }
    // two frames in one submission, separated only by the passes' own barriers
    let pass = IrradiancePass::new(&gpu).unwrap();
    let mut moving = Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::default()).unwrap();
    gpu.submit("frames", |cmd| {
        for sky in [Sky::with_sun(0.2, 0.0), Sky::default()] {
            moving.update_sky(cmd, &sky);
            pass.record(cmd, &moving);
        }
    })
    .unwrap();
    assert_eq!(first, pass.coefficients().read_all::<[f32; 4]>().unwrap());
}

/// Under two coloured lamps, of 12° and 20°, order 2 has an error of several percent; its residual restores the exact irradiance.
#[test]
fn the_rest_completes_order_two() {
    let Some(gpu) = test_gpu() else { return };
    let lamps = [
        (DVec3::new(0.5, -0.6, 0.6).normalize(), 12f64, DVec3::new(40.0, 20.0, 5.0)),
        (DVec3::new(-0.7, 0.1, -0.4).normalize(), 20.0, DVec3::new(2.0, 6.0, 10.0)),
    ];
    let image = panorama(512, |d| {
        let lit = |(at, half, radiance): &(DVec3, f64, DVec3)| {
            if d.dot(*at) > half.to_radians().cos() { *radiance } else { DVec3::ZERO }
        };
        DVec3::splat(0.2) + lamps.iter().map(lit).sum::<DVec3>()
    });
    let none = LightExtraction { count: 0, ..Default::default() };
    let environment = Environment::from_panorama(&gpu, 128, &image, none).unwrap();
    let order_two = sh(&run(&gpu, &environment));
    let texels = leadr_testing::cube::read_level(&environment, 0);
    let (mut squares, mut rotated, mut whole) = ([0.0; 2], 0.0, 0.0);
    for (n, _, rest) in read_image_level(environment.irradiance_rest(), 0) {
        let exact = |n: DVec3| texels.iter().map(|(d, w, l)| n.dot(*d).max(0.0) * w * l).sum::<DVec3>();
        let (want, low) = (exact(n), sh_irradiance(&order_two, n));
        squares[0] += (low - want).length_squared();
        squares[1] += (low + rest - want).length_squared();
        let rotated_normal = DVec3::new(-n.y, n.x, n.z);
        rotated += (sh_irradiance(&order_two, rotated_normal) + rest - exact(rotated_normal)).length_squared();
        whole += want.length_squared();
    }
    let [without, with, rotated] = [squares[0], squares[1], rotated].map(|s: f64| (s / whole).sqrt());
    println!(
        "irradiance by order 2 errs by {without:.4}, with its rest by {with:.4}, with a rest turned by 90° by {rotated:.4}"
    );
    assert!(with < 0.006 && without > 0.04 && rotated > 0.04);
}

#[test]
fn a_constant_environment_has_only_its_mean() {
    let Some(gpu) = test_gpu() else { return };
    let color = DVec3::new(0.5, 1.0, 1000.0);
    let environment = Environment::from_equirect(&gpu, Environment::FACE_SIZE, &panorama(64, |_| color)).unwrap();
    let mut exact = [DVec3::ZERO; 9];
    exact[0] = 2.0 * PI.sqrt() * color;
    let got = error(&sh(&run(&gpu, &environment)), &exact);
    println!("constant: {got:.2e}");
    // the midpoint rule on 64² faces has the cube's symmetry, so order 2 cancels
    assert!(got < 3e-6);
}

#[test]
fn cosine_lobes_have_their_closed_form() {
    let Some(gpu) = test_gpu() else { return };
    for n in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z, DVec3::new(0.48, -0.6, 0.64)] {
        let color = DVec3::new(1.0, 2.0, 0.25);
        let lobe = panorama(1024, |d| d.dot(n).max(0.0) * color);
        let environment = Environment::from_equirect(&gpu, Environment::FACE_SIZE, &lobe).unwrap();
        // Ramamoorthi & Hanrahan 2001: A_0 = π, A_1 = 2π/3, A_2 = π/4 times the basis at the lobe's axis
        let basis = sh_basis(n);
        let exact: Sh9 = std::array::from_fn(|k| {
            basis[k] * color * [PI, 2.0 * PI / 3.0, PI / 4.0][usize::from(k > 0) + usize::from(k > 3)]
        });
        let got = error(&sh(&run(&gpu, &environment)), &exact);
        println!("cosine about {n}: {got:.2e}");
        assert!(got < 3e-4, "{n}: {got}");
    }
}
