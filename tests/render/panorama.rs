//! Panoramas as an image and extracted suns: the extraction, and its lighting.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use leadr::maps::RgbImage;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::panorama::{EnvironmentLight, LightExtraction, Split, split};
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::{RenderSettings, Shading, ShadingOptions, Technique};
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::cube_sphere;
use leadr_testing::cube::panorama;
use leadr_testing::gpu::{TestGpu, test_gpu};

const NONE: LightExtraction = LightExtraction { count: 0, threshold: 8.0 };

fn lights_of(image: &RgbImage) -> Split {
    split(image, LightExtraction::default())
}

fn solid_angle(image: &RgbImage, row: usize) -> f64 {
    let edge = |row: usize| (PI * row as f64 / f64::from(image.height)).cos();
    2.0 * PI / f64::from(image.width) * (edge(row) - edge(row + 1))
}

/// Power of every texel per channel.
fn power(image: &RgbImage) -> DVec3 {
    let texels = image.texels.iter().enumerate();
    texels.map(|(i, t)| Vec3::from(*t).as_dvec3() * solid_angle(image, i / image.width as usize)).sum()
}

fn without_lights(image: &RgbImage, parts: &Split) -> RgbImage {
    let mut rest = image.clone();
    for &(index, texel) in &parts.rest {
        rest.texels[index] = texel;
    }
    rest
}

/// A disk with a soft edge, so that a texel image follows its movement.
fn disk(d: DVec3, middle: DVec3, radius_degrees: f64) -> f64 {
    let angle = d.angle_between(middle.normalize()).to_degrees();
    1.0 - ((angle - radius_degrees) / 0.8 + 0.5).clamp(0.0, 1.0)
}

/// The same with an edge wider than a texel of the smaller panoramas, so that no texel changes abruptly.
fn glow(d: DVec3, middle: DVec3, radius_degrees: f64) -> f64 {
    let angle = d.angle_between(middle.normalize()).to_degrees();
    let x = ((radius_degrees - angle) / 4.0 + 0.5).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[test]
fn one_bright_pixel_becomes_one_light() {
    for (width, column, row) in
        [(1024u32, 300u32, 200u32), (1024, 0, 255), (1024, 1023, 40), (1024, 700, 0), (256, 9, 127), (64, 5, 20)]
    {
        let mut image = panorama(width, |_| DVec3::ONE);
        let at = (row * width + column) as usize;
        // A texel at the pole is small.
        let bright = if row == 0 { 100.0 } else { 1.0 };
        image.texels[at] = [1e5 * bright, 2e5 * bright, 5e4 * bright];
        let parts = lights_of(&image);
        let [light] = parts.lights[..] else { panic!("{width} {column},{row}: {:?}", parts.lights) };
        let (theta, phi) = (
            PI * (f64::from(row) + 0.5) / f64::from(image.height),
            2.0 * PI * (0.5 - (f64::from(column) + 0.5) / f64::from(width)),
        );
        let expected_direction = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        assert!(light.direction.as_dvec3().distance(expected_direction) < 1e-5, "{light:?} {expected_direction}");
        let irradiance = DVec3::new(1e5, 2e5, 5e4) * f64::from(bright) * solid_angle(&image, row as usize);
        assert!((light.irradiance.as_dvec3() / irradiance - 1.0).abs().max_element() < 1e-3, "{light:?} {irradiance}");
        assert!(light.radius_degrees() < 400.0 / width as f32, "{light:?}");
        // The residual matches its surroundings.
        let left = Vec3::from(without_lights(&image, &parts).texels[at]);
        assert!(parts.rest.len() == 1 && left.max_element() < 40.0, "{left}");
    }
}

#[test]
fn image_and_lights_together_have_the_power_of_the_panorama() {
    let suns = [
        (DVec3::new(-1.0, 0.02, 0.4), 2.0, 900.0),
        (DVec3::new(0.1, 0.0, 1.0), 1.0, 3000.0),
        (DVec3::new(1.0, -1.0, -0.3), 3.0, 300.0),
    ];
    let image = panorama(512, |d| {
        let sky = DVec3::new(0.5, 0.7, 1.0) * (1.2 + d.z);
        sky + suns
            .iter()
            .map(|&(middle, radius, l)| disk(d, middle, radius) * l * DVec3::new(1.0, 0.9, 0.7))
            .sum::<DVec3>()
    });
    let parts = lights_of(&image);
    assert_eq!(parts.lights.len(), 3);
    let rest = without_lights(&image, &parts);
    assert!(rest.texels.iter().flatten().all(|&v| v >= 0.0));
    let sum = power(&rest) + parts.lights.iter().map(|l| l.irradiance.as_dvec3()).sum::<DVec3>();
    assert!((sum / power(&image) - 1.0).abs().max_element() < 1e-6, "{sum} {}", power(&image));
    for (middle, radius, _) in suns {
        let nearest = |l: &&EnvironmentLight| l.direction.as_dvec3().distance(middle.normalize()) < 2e-3;
        let light = parts.lights.iter().find(nearest).unwrap_or_else(|| panic!("{middle}: {:?}", parts.lights));
        assert!((f64::from(light.radius_degrees()) - radius).abs() < 0.25, "{light:?}");
    }
    assert_eq!(parts, lights_of(&image));
    // At most the requested number of lights, and none for zero.
    assert_eq!(split(&image, NONE), Split::default());
    assert!(split(&image, LightExtraction { count: 1, threshold: 8.0 }).lights.len() <= 1);
}

#[test]
fn large_and_many_things_stay_in_the_image() {
    let tubes = |d: DVec3| {
        let (across, along) = (d.y.atan2(d.z).to_degrees(), d.x.asin().to_degrees());
        d.z > 0.0 && along.abs() < 25.0 && across.abs() < 42.0 && (across.rem_euclid(12.0) - 6.0).abs() < 0.6
    };
    let fireflies = |d: DVec3| {
        let (theta, phi) = (d.z.acos() / PI * 128.0, d.y.atan2(d.x) / PI * 128.0);
        (theta as i32 % 16, (phi + 128.0) as i32 % 16) == (5, 7)
    };
    type Picture<'a> = Box<dyn Fn(DVec3) -> f64 + 'a>;
    let cases: [(&str, Picture<'_>); 7] = [
        ("an even sphere", Box::new(|_| 3.0)),
        ("darkness", Box::new(|_| 0.0)),
        ("a bright sky", Box::new(|d: DVec3| if d.z > 0.0 { 5.0 } else { 0.1 })),
        ("a soft box", Box::new(|d: DVec3| 0.1 + 400.0 * disk(d, DVec3::new(1.0, 0.5, 0.5), 12.0))),
        ("a row of thin tubes", Box::new(move |d: DVec3| if tubes(d) { 500.0 } else { 0.1 })),
        ("a single long tube", Box::new(|d: DVec3| if d.z.abs() < 0.01 && d.x > 0.9 { 500.0 } else { 0.1 })),
        ("fireflies", Box::new(move |d: DVec3| if fireflies(d) { 3e3 } else { 1.0 })),
    ];
    for (name, radiance) in cases {
        let parts = lights_of(&panorama(256, |d| DVec3::splat(radiance(d))));
        assert_eq!(parts, Split::default(), "{name}");
    }
}

/// Irradiance of a few surfaces from the lights.
fn received(parts: &Split) -> Vec<f64> {
    let normals = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::ONE.normalize()];
    let on = |n: DVec3| {
        let lights = parts.lights.iter();
        lights.map(|l| f64::from(l.irradiance.y) * l.direction.as_dvec3().dot(n).max(0.0)).sum::<f64>()
    };
    normals.into_iter().map(on).collect()
}

/// Largest change of the lights' irradiance over a sequence of `steps` pictures, relative to its maximum.
fn largest_step(steps: u32, picture: impl Fn(f64) -> RgbImage) -> f64 {
    let path: Vec<Vec<f64>> =
        (0..=steps).map(|i| received(&lights_of(&picture(f64::from(i) / f64::from(steps))))).collect();
    let most = path.iter().flatten().fold(1e-9, |a: f64, &b| a.max(b));
    let steps = path.windows(2).flat_map(|w| w[0].iter().zip(&w[1]).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>());
    steps.fold(0.0, f64::max) / most
}

/// A jump is independent of the step size; a continuous change shrinks with it.
#[test]
#[ignore = "long"]
fn nothing_pops_when_the_picture_changes_slowly() {
    let sun = DVec3::new(0.8, 0.3, 0.5).normalize();
    let sky = |d: DVec3| DVec3::splat(1.0 + 0.5 * d.z);
    let pair = |degrees: f64, ratio: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (a, b) = (DVec3::X, DVec3::new(cos, sin, 0.0));
        panorama(256, move |d| sky(d) + 800.0 * (glow(d, a, 2.0) + ratio * glow(d, b, 2.0)))
    };
    type Path<'a> = Box<dyn Fn(f64) -> RgbImage + 'a>;
    let paths: [(&str, Path<'_>); 9] = [
        (
            "a sun that rises out of the sky",
            Box::new(|t| panorama(256, |d| sky(d) + t * t * 600.0 * glow(d, sun, 2.0))),
        ),
        ("a sun that grows", Box::new(|t| panorama(256, |d| sky(d) + 300.0 * glow(d, sun, 1.5 + 14.0 * t)))),
        (
            "a sun that goes round",
            Box::new(|t| {
                let (sin, cos) = (3.0 + 0.4 * t).sin_cos();
                panorama(256, move |d| sky(d) + 800.0 * glow(d, DVec3::new(cos, sin, 0.3), 2.0))
            }),
        ),
        (
            "a sun over the pole",
            Box::new(|t| panorama(256, move |d| sky(d) + 800.0 * glow(d, DVec3::new(0.3 * (t - 0.5), 0.02, 1.0), 2.0))),
        ),
        ("equal suns that part", Box::new(|t| pair(40.0 * t, 1.0))),
        ("unequal suns that part", Box::new(|t| pair(40.0 * t, 0.4))),
        ("one sun that takes over from the other", Box::new(|t| pair(30.0, 2.0 * t))),
        (
            "a sun that becomes a tube",
            Box::new(|t| {
                let ends = 1.0 + 12.0 * t;
                panorama(256, move |d| {
                    let (along, across) = (d.y.atan2(d.x).to_degrees(), d.z.asin().to_degrees());
                    sky(d)
                        + 500.0
                            * ((ends - along.abs()) / 0.8 + 0.5).clamp(0.0, 1.0)
                            * glow(DVec3::new(1.0, 0.0, across.to_radians()), DVec3::X, 1.0)
                })
            }),
        ),
        (
            "a fifth and a sixth lamp",
            Box::new(|t| {
                let lamp = |k: i32| {
                    let (sin, cos) = (f64::from(k)).sin_cos();
                    DVec3::new(cos, sin, 0.4 * f64::from(k % 3 - 1))
                };
                let brightness = move |k: i32| {
                    if k < 4 { 800.0 + 100.0 * f64::from(k) } else { 1600.0 * t - 400.0 * f64::from(k - 4) }
                };
                panorama(256, move |d| {
                    sky(d) + (0..6).map(|k| brightness(k).max(0.0) * glow(d, lamp(k), 2.0)).sum::<f64>()
                })
            }),
        ),
    ];
    for (name, path) in paths {
        let (coarse, fine) = (largest_step(40, &path), largest_step(160, &path));
        println!("{name}: {coarse:.4}, in a quarter of the steps {fine:.4}");
        assert!(fine < 0.45 * coarse.max(0.02) && coarse < 0.8, "{name}: {coarse} {fine}");
    }
}

fn black_with_one_pixel(row: usize, column: usize, radiance: [f32; 3]) -> RgbImage {
    let mut image = panorama(512, |_| DVec3::ZERO);
    image.texels[row * 512 + column] = radiance;
    image
}

fn ball(albedo: f32, roughness: f32, f0: f32) -> Object {
    Object::new("ball", cube_sphere(16, [albedo, albedo, albedo, roughness])).with_specular_f0(f0)
}

fn state(objects: usize) -> FrameState {
    let camera = Camera::looking_at(Vec3::new(3.0, -2.5, 2.0), Vec3::ZERO, 30.0);
    FrameState::new(camera, vec![Pose::REST; objects])
}

fn under(gpu: &TestGpu, objects: Vec<Object>, image: &RgbImage, lights: LightExtraction) -> Renderer {
    Renderer::new(gpu, objects, Environment::from_panorama(gpu, 256, image, lights).unwrap()).unwrap()
}

fn settings(shading: Shading) -> RenderSettings {
    RenderSettings { size: (96, 96), shading, samples: 1, ..Default::default() }
}

/// Lambert's law, for every shading technique, including the reference without shadows of the relief.
#[test]
fn a_sun_of_one_pixel_lights_a_sphere_by_the_cosine() {
    let Some(gpu) = test_gpu() else { return };
    let image = black_with_one_pixel(90, 200, [3e5, 2e5, 1e5]);
    let mut renderer = under(&gpu, vec![ball(0.5, 0.4, 0.0)], &image, LightExtraction::default());
    let light = renderer.environment().lights()[0];
    for technique in [Technique::Leadr, Technique::LeadrGgx, Technique::Reference, Technique::Toksvig, Technique::Lean]
    {
        let settings = RenderSettings { shadows: false, ..settings(technique.with(ShadingOptions::default())) };
        let output = renderer.render(&state(1), &settings).unwrap();
        let normals = renderer.layer(leadr::render::frame::Layer::Normal).unwrap();
        let (mut worst, mut count) = (0.0f32, 0);
        for (color, normal) in output.color.iter().zip(&normals).filter(|(color, _)| color[3] == 1.0) {
            let normal = Vec3::new(normal[0], normal[1], normal[2]);
            // Towards the rim a pixel covers many normals.
            if normal.dot(state(1).camera.position.normalize()) < 0.5 {
                continue;
            }
            let cosine = light.direction.dot(normal).max(0.0);
            let want = light.irradiance * (0.5 / std::f32::consts::PI * cosine);
            worst =
                worst.max((Vec3::new(color[0], color[1], color[2]) - want).abs().max_element() / light.irradiance.x);
            count += usize::from(cosine > 0.2);
        }
        println!("{technique:?}: off by {worst:.1e} of the irradiance over {count} lit pixels");
        assert!(count > 500 && worst < 0.01 * 0.5 / std::f32::consts::PI, "{technique:?}: {worst}");
    }
}

/// Specular reflections of an extracted light are as bright as those of its image.
#[test]
fn mirrors_reflect_as_much_with_lights_as_without() {
    let Some(gpu) = test_gpu() else { return };
    let sun = DVec3::new(0.9, -0.2, 0.7);
    let image = panorama(512, |d| DVec3::splat(0.2 + 300.0 * disk(d, sun, 3.0)));
    let mut renderers =
        [NONE, LightExtraction::default()].map(|lights| under(&gpu, vec![ball(0.0, 0.25, 1.0)], &image, lights));
    assert_eq!(renderers.each_ref().map(|r| r.environment().lights().len()), [0, 1]);
    for technique in [Technique::Leadr, Technique::LeadrGgx, Technique::Toksvig, Technique::Lean] {
        let settings = RenderSettings { shadows: false, ..settings(technique.with(ShadingOptions::default())) };
        let [image_alone, split] = renderers.each_mut().map(|renderer| {
            let output = renderer.render(&state(1), &settings).unwrap();
            output.color.iter().filter(|c| c[3] == 1.0).map(|c| f64::from(c[1])).sum::<f64>()
        });
        println!("{technique:?}: {:.4} of the light", split / image_alone);
        assert!((split / image_alone - 1.0).abs() < 0.08, "{technique:?}");
    }
}

/// Order-2 harmonics of image and lights together equal those of the panorama.
#[test]
fn the_mean_light_is_conserved_on_the_device() {
    let Some(gpu) = test_gpu() else { return };
    let image =
        panorama(512, |d| DVec3::new(1.0 + d.x, 1.0, 1.0 - d.z) + 500.0 * disk(d, DVec3::new(-0.4, 1.0, 0.8), 1.5));
    let [whole, rest] = [NONE, LightExtraction::default()].map(|lights| {
        let mut renderer = under(&gpu, vec![ball(0.5, 0.5, 0.04)], &image, lights);
        renderer.render(&state(1), &settings(Shading::default())).unwrap();
        let lights: f32 = renderer.environment().lights().iter().map(|l| l.irradiance.y).sum();
        renderer.radiance_sh().unwrap()[0][1] + 0.282_094_8 * lights
    });
    assert!((rest / whole - 1.0).abs() < 1e-3, "{rest} {whole}");
}

/// The sun stays visible at its position, and the panorama can be replaced at any time.
#[test]
fn backgrounds_keep_suns_and_panoramas_can_be_replaced() {
    let Some(gpu) = test_gpu() else { return };
    let sun = |x: f64| panorama(512, move |d| DVec3::splat(0.5) + 400.0 * disk(d, DVec3::new(x, 1.0, 0.2), 2.0));
    let seen = |renderer: &mut Renderer| renderer.render(&towards(), &settings(Shading::default())).unwrap().color;
    let [first, second] = [sun(0.1), sun(-0.1)];
    let [mut with, mut without] =
        [LightExtraction::default(), NONE].map(|l| under(&gpu, vec![ball(0.5, 0.3, 0.04)], &first, l));
    let (lit, plain) = (seen(&mut with), seen(&mut without));
    let behind = |color: &[[f32; 4]]| color.iter().filter(|c| c[3] == 0.0).map(|c| c[1]).collect::<Vec<_>>();
    assert!(behind(&plain).iter().any(|&l| l > 100.0), "the sun is in the picture");
    assert_eq!(behind(&lit), behind(&plain));
    let fresh = seen(&mut under(&gpu, vec![ball(0.5, 0.3, 0.04)], &second, LightExtraction::default()));
    let old = with.set_environment(Environment::from_equirect(&gpu, 256, &second).unwrap());
    assert!(seen(&mut with) == fresh && fresh != lit);
    with.set_environment(old);
    assert!(seen(&mut with) == lit);
    // For a sky updated on the device, nothing is extracted.
    let sky = Environment::from_sky(&gpu, 64, &Sky::default()).unwrap();
    assert!(sky.lights().is_empty());
    with.set_environment(sky);
    let paused = with.prepare(&towards(), &settings(Shading::default())).unwrap().pause();
    with.set_environment(Environment::from_equirect(&gpu, 64, &second).unwrap());
    assert!(with.resume(paused).is_err(), "the frame was prepared for other lights");
}

/// A camera looking past the ball toward the suns.
fn towards() -> FrameState {
    let camera = Camera::looking_at(Vec3::new(0.9, -5.0, -0.6), Vec3::new(0.8, 0.0, 0.4), 45.0);
    FrameState::new(camera, vec![Pose::REST])
}

/// Two suns cast one shadow each, also with resolved edge samples.
#[test]
fn every_sun_casts_a_shadow() {
    let Some(gpu) = test_gpu() else { return };
    let image = panorama(512, |d| {
        DVec3::splat(0.02)
            + 800.0
                * (disk(d, DVec3::new(1.0, 0.3, 1.0), 1.5)
                    + DVec3::new(0.2, 0.5, 1.0) * disk(d, DVec3::new(-1.0, 0.3, 1.0), 1.5))
    });
    let white = [0.8, 0.8, 0.8, 0.9];
    let floor = Object::new("floor", plane(6.0, 16, 1.0, white, even)).with_specular_f0(0.0).without_shadow();
    let mut renderer = under(&gpu, vec![floor, ball(0.5, 0.9, 0.0)], &image, LightExtraction::default());
    let suns: Vec<EnvironmentLight> = renderer.environment().lights().to_vec();
    assert_eq!(suns.len(), 2);
    let camera = Camera::looking_at(Vec3::new(0.0, -0.01, 14.0), Vec3::ZERO, 45.0);
    let at = Pose::Rigid(glam::Affine3A::from_translation(Vec3::Z * 1.5));
    let state = FrameState::new(camera, vec![Pose::REST, at]);
    let (mut pictures, size) = (Vec::new(), 120);
    for edge_samples in [1, 16] {
        let shading = Technique::Leadr.with(ShadingOptions { edge_samples, ..Default::default() });
        let settings = RenderSettings { size: (size, size), ..settings(shading) };
        pictures.push(renderer.render(&state, &settings).unwrap().color);
    }
    let half = 14.0 * (22.5f32).to_radians().tan();
    let pixel = |x: f32, y: f32| {
        let across = |v: f32| ((v / half * 0.5 + 0.5) * size as f32) as usize;
        across(-y) * size as usize + across(x)
    };
    for (i, sun) in suns.iter().enumerate() {
        // The intersection of the floor with the sun's ray through the ball's centre.
        let shadow = Vec3::Z * 1.5 - sun.direction * (1.5 / sun.direction.z);
        let other = suns[1 - i];
        for picture in &pictures {
            let color = Vec3::from_slice(&picture[pixel(shadow.x, shadow.y)][..3]);
            let want = 0.8 * (other.irradiance * (other.direction.z / std::f32::consts::PI) + 0.02);
            assert!((color / want - 1.0).abs().max_element() < 0.02, "{color} {want} at {shadow}");
        }
        let lit = pictures[0][pixel(0.0, -5.0)][1];
        assert!(lit > 1.15 * pictures[0][pixel(shadow.x, shadow.y)][1]);
    }
    let [one, many] = &pictures[..] else { unreachable!() };
    let differ = one.iter().zip(many).filter(|(a, b)| (a[1] - b[1]).abs() > 0.1 * a[1].max(b[1])).count();
    println!("{differ} of {} pixels differ by 10 % with edge samples", one.len());
    assert!(differ < one.len() / 40);
}
