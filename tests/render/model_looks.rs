//! Appearance of materials, lights and cameras of glTF files.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine2, Mat4, Vec2, Vec3};
use leadr::gpu::Gpu;
use leadr::maps::material::{Encoding, Input, Material, Opacity, Raster, Samples, Texture, TextureWrap};
use leadr::models::{self, Light, LightKind, Mesh, Model, Node, Primitive, Projection, SceneRoots, Transform};
use leadr::reflectance::color::luminance;
use leadr::render::camera::Camera;
use leadr::render::light::exposure::exposure;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Pose, Sun};
use leadr::render::settings::{RenderSettings, Shading, ShadingOptions, Technique};
use leadr::scenes::model::{Ground, ModelChoice, stage};
use leadr::scenes::stage::{Lights, Stage};
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::{in_room, under_sky};

fn node(transform: Transform) -> Node {
    Node {
        name: String::new(),
        parent: None,
        children: Vec::new(),
        transform,
        mesh: None,
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
        visible: true,
    }
}

/// A square of two metres facing +z (-y in world space), with two coordinate sets: upright, and rotated by a quarter turn.
fn square(material: Material) -> Model {
    let primitive = Primitive {
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        texcoords: vec![
            vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            vec![[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]],
        ],
        ..Primitive::default()
    };
    Model {
        name: "square".into(),
        scenes: vec![SceneRoots { name: String::new(), roots: vec![0] }],
        nodes: vec![Node { mesh: Some(0), ..node(Transform::IDENTITY) }],
        order: vec![0],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        materials: vec![material],
        ..Model::default()
    }
}

fn texture(size: u32, channels: usize, texel: impl Fn(u32, u32) -> Vec<u8>) -> Texture {
    let codes = (0..size * size).flat_map(|i| texel(i % size, i / size)).collect();
    Texture::new(Raster::new(size, size, channels, Samples::U8(codes)).unwrap(), "texture", Encoding::Linear)
}

/// Red grows to the right, green downwards.
fn ramps() -> Texture {
    let code = |k: u32| ((k as f32 + 0.5) / 64.0 * 255.0 + 0.5) as u8;
    texture(64, 3, |x, y| vec![code(x), code(y), 0])
}

/// A purely diffuse material.
fn matte(albedo: f32) -> Material {
    Material {
        base_color: Input::constant([albedo; 3]),
        specular: Input::constant(0.0),
        f0: Input::constant([0.0; 3]),
        roughness: Input::constant(1.0),
        ..Material::new("matte")
    }
}

fn stage_of(model: Model) -> Stage {
    stage(ModelChoice::new(model, None).unwrap()).unwrap()
}

/// The centre of the square in the world.
const MIDDLE: Vec3 = Vec3::Z;

fn facing(distance: f32) -> Camera {
    Camera::looking_at(MIDDLE - distance * Vec3::Y, MIDDLE, 30.0)
}

struct Picture {
    color: Vec<[f32; 4]>,
    width: u32,
}

impl Picture {
    fn mean(&self, channel: usize) -> f64 {
        self.color.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / self.color.len() as f64
    }

    fn middle(&self) -> [f32; 4] {
        self.color[self.color.len() / 2 + self.width as usize / 2]
    }
}

/// Only the square, in the dark or under a sky.
fn drawn(gpu: &Arc<Gpu>, model: Model, camera: Camera, sky: Option<Sky>, settings: &RenderSettings) -> Picture {
    let mut stage = stage_of(model);
    let lights = Lights { sky, ..Lights::default() };
    let state = stage.state(0.0, &camera, &lights);
    let object = stage.objects.swap_remove(0);
    let state = FrameState { poses: state.poses[..1].to_vec(), ..state };
    let mut renderer = match sky {
        Some(_) => under_sky(gpu, vec![object], 16),
        None => in_room(gpu, vec![object], [0.0; 3]),
    };
    Picture { color: renderer.render(&state, settings).unwrap().color, width: settings.size.0 }
}

fn settings(samples: u32, shading: impl Into<Shading>) -> RenderSettings {
    RenderSettings { size: (48, 48), samples, shading: shading.into(), ..RenderSettings::default() }
}

/// One cell in four of a square emits 4, so its mean emission is 1 at every distance, with and without the G-buffer.
#[test]
fn emission_keeps_its_energy() {
    let Some(gpu) = test_gpu() else { return };
    let shining = |x: u32, y: u32| x.is_multiple_of(2) && y.is_multiple_of(2);
    let texture = texture(32, 3, |x, y| if shining(x, y) { vec![255, 255, 51] } else { vec![0; 3] });
    let emission = Input { factor: [4.0; 3], ..Input::colors(texture) };
    let material = Material { emission, ..matte(0.0) };
    let leadr = Technique::Leadr;
    for distance in [4.5, 60.0] {
        let many = drawn(&gpu, square(material.clone()), facing(distance), None, &settings(64, Technique::Reference));
        let coverage = many.mean(3);
        let fused = drawn(&gpu, square(material.clone()), facing(distance), None, &settings(16, leadr));
        let edges = leadr.with(ShadingOptions { edge_samples: 16, ..ShadingOptions::default() });
        let joined = drawn(&gpu, square(material.clone()), facing(distance), None, &settings(1, edges));
        for (name, picture) in [("reference", &many), ("fused", &fused), ("edge samples", &joined)] {
            let (red, blue) = (picture.mean(0) / coverage, picture.mean(2) / coverage);
            println!("at {distance} m, {name}: {red:.4}, {blue:.4} of 1 and 0.2; coverage {coverage:.4}");
            assert!((red - 1.0).abs() < 0.02 && (blue - 0.2).abs() < 0.004, "{name} at {distance}: {red}, {blue}");
        }
    }
}

/// A material without `unlit` is lit; with `unlit` it shows its colour under any light and in the dark.
#[test]
fn unlit_surfaces_show_base_colour() {
    let Some(gpu) = test_gpu() else { return };
    let material = |unlit| Material { unlit, base_color: Input::constant([0.8, 0.4, 0.1]), ..Material::new("flat") };
    for sky in [None, Some(Sky::default())] {
        let pixel =
            |unlit| drawn(&gpu, square(material(unlit)), facing(5.0), sky, &settings(1, Technique::Leadr)).middle();
        let (unlit, lit) = (pixel(true), pixel(false));
        println!("under a sky: {}, unlit {unlit:?}, lit {lit:?}", sky.is_some());
        for (seen, wanted) in unlit.iter().zip([0.8, 0.4, 0.1]) {
            assert!((seen - wanted).abs() < 2e-3, "{unlit:?}");
        }
        assert!((lit[0] - 0.8).abs() > 0.02, "{lit:?}");
    }
}

/// An occlusion map dims only ambient light, at its strength, and no lamp.
#[test]
fn occlusion_dims_the_surroundings_alone() {
    let Some(gpu) = test_gpu() else { return };
    let stage = |strength: f32| {
        let occlusion = Input::texture(texture(4, 1, |_, _| vec![51]), 0);
        let material = Material { occlusion, occlusion_strength: strength, ..matte(0.5) };
        stage_of(square(material))
    };
    let radiance = |strength: f32, room: f32, lamp: f32| {
        let mut stage = stage(strength);
        let state = stage.state(0.0, &facing(5.0), &Lights::default());
        let lamps = [leadr::render::scene::PointLight::new(MIDDLE - 2.0 * Vec3::Y, Vec3::splat(lamp))];
        let state = FrameState { poses: state.poses[..1].to_vec(), point_lights: lamps.to_vec(), ..state };
        let mut renderer = in_room(&gpu, vec![stage.objects.swap_remove(0)], [room; 3]);
        let color = renderer.render(&state, &settings(1, Technique::Leadr)).unwrap().color;
        color[24 * 48 + 24][0]
    };
    let (open, half, hidden) = (radiance(0.0, 1.0, 0.0), radiance(0.5, 1.0, 0.0), radiance(1.0, 1.0, 0.0));
    println!("open {open:.4}, half {half:.4}, hidden {hidden:.4}");
    assert!((half / open - 0.6).abs() < 0.005 && (hidden / open - 0.2).abs() < 0.005);
    assert!((radiance(1.0, 0.0, 3.0) / radiance(0.0, 0.0, 3.0) - 1.0).abs() < 1e-4);
}

/// Exact coverage of a mask of small leaves: where the interpolated texels reach the cutoff.
fn covered_share(texels: &[u8], size: u32, cutoff: f32) -> f64 {
    let at = |x: u32, y: u32| f32::from(texels[(y % size * size + x % size) as usize]) / 255.0;
    let side = 32;
    let count = (0..size * side).flat_map(|v| (0..size * side).map(move |u| (u, v))).filter(|&(u, v)| {
        let (x, y) = ((u as f32 + 0.5) / side as f32, (v as f32 + 0.5) / side as f32);
        let (i, j) = (x as u32, y as u32);
        let (s, t) = (x - i as f32, y - j as f32);
        let row = |j: u32| at(i, j) + s * (at(i + 1, j) - at(i, j));
        row(j) + t * (row(j + 1) - row(j)) >= cutoff
    });
    count.count() as f64 / f64::from(size * side * size * side)
}

#[test]
#[ignore = "long"]
fn masks_keep_their_coverage_at_every_distance() {
    let Some(gpu) = test_gpu() else { return };
    let size = 64;
    // Leaves of several texels; a mean of the mask would remove them at a distance.
    let leaf = |x: u32, y: u32| {
        let (i, j) = ((x % 8) as f32 - 3.5, (y % 8) as f32 - 3.5);
        (230.0 - 60.0 * (i * i + j * j).sqrt()).clamp(0.0, 255.0) as u8
    };
    let texels: Vec<u8> = (0..size * size).map(|i| leaf(i % size, i / size)).collect();
    let mean = texels.iter().map(|&t| f64::from(t) / 255.0).sum::<f64>() / texels.len() as f64;
    let mut checked = 0;
    for cutoff in [0.5, 0.3] {
        let share = covered_share(&texels, size, cutoff);
        // Averaging the mask before the comparison loses all coverage.
        assert!(mean < f64::from(cutoff) && share > 0.1, "{mean} {share}");
        let mask = Input::texture(texture(size, 1, |x, y| vec![leaf(x, y)]), 0);
        let material = Material { opacity: Opacity::Mask { mask, cutoff }, ..matte(0.5) };
        for distance in [4.5, 12.0, 80.0] {
            for (samples, msaa) in [(64, 1), (16, 4), (1, 4)] {
                let settings = RenderSettings { msaa, ..settings(samples, Technique::Leadr) };
                let camera = facing(distance);
                let masked = drawn(&gpu, square(material.clone()), camera, None, &settings).mean(3);
                let whole = drawn(&gpu, square(matte(0.5)), camera, None, &settings).mean(3);
                let error = masked / whole / share - 1.0;
                println!(
                    "cutoff {cutoff}, {distance} m, {samples} x {msaa} samples: {:.4} of {share:.4}, {:+.2} %",
                    masked / whole,
                    100.0 * error
                );
                // A few samples hit a square of a few pixels at random.
                let seen = whole * f64::from(48 * 48 * samples * msaa);
                let noise = ((1.0 - share) / (share * seen)).sqrt();
                if noise > 0.3 {
                    continue;
                }
                checked += 1;
                let systematic = if samples == 1 { 0.08 } else { 0.02 };
                assert!(error.abs() < systematic + 2.5 * noise, "{error}, noise {noise}");
            }
        }
    }
    assert!(checked >= 16, "{checked}");
}

/// Partly opaque surfaces are visible to a fraction of the samples. Two of them in a row transmit the product of their transmittances.
#[test]
fn blended_surfaces_cover_by_their_share() {
    let Some(gpu) = test_gpu() else { return };
    let material = Material { opacity: Opacity::Blend { share: Input::constant(0.4) }, ..matte(0.5) };
    let mut model = square(material);
    let behind = Vec3::new(0.0, 0.0, -0.2);
    model.nodes.push(Node { mesh: Some(0), ..node(Transform::Matrix(Mat4::from_translation(behind))) });
    model.order.push(1);
    for (roots, wanted) in [(vec![0], 0.4), (vec![0, 1], 0.64)] {
        model.scenes[0].roots = roots;
        let picture = drawn(&gpu, model.clone(), facing(3.0), None, &settings(64, Technique::Leadr));
        let share = picture.mean(3);
        println!("{share:.4} of {wanted}");
        assert!((share - wanted).abs() < 0.015, "{share}");
    }
}

/// Every pixel of a textured square has the colour given by the transform, the wrap and the coordinate set.
#[test]
fn textures_follow_their_transforms_wraps_and_coordinates() {
    let Some(gpu) = test_gpu() else { return };
    let rotated = Affine2::from_scale_angle_translation(Vec2::splat(1.5), 0.4, Vec2::new(-0.2, 0.1));
    let twice = Affine2::from_scale(Vec2::splat(2.0));
    let clamp = |v: f32| v.clamp(0.5 / 64.0, 1.0 - 0.5 / 64.0);
    let mirror = |v: f32| 1.0 - (v.rem_euclid(2.0) - 1.0).abs();
    type Beyond<'a> = &'a dyn Fn(f32) -> f32;
    let cases: [(u32, Affine2, TextureWrap, Beyond<'_>); 4] = [
        (0, rotated, TextureWrap::Clamp, &clamp),
        (0, twice, TextureWrap::Mirror, &mirror),
        (1, Affine2::IDENTITY, TextureWrap::Repeat, &|v| v),
        (1, rotated, TextureWrap::Clamp, &clamp),
    ];
    for (coordinates, transform, wrap, beyond) in cases {
        let texture = Texture { coordinates, transform, wrap: [wrap; 2], ..ramps() };
        // The emission uses the other set; neither may use the other's.
        let glow = Texture { coordinates: 1 - coordinates, ..ramps() };
        let material = Material { base_color: Input::colors(texture), emission: Input::colors(glow), ..matte(0.5) };
        let camera = facing(5.0);
        let settings = settings(1, Technique::Constant);
        let picture = drawn(&gpu, square(material), camera, None, &settings);
        let [x, y, z] = camera.rays(settings.size, Vec2::ZERO);
        let (mut seen, mut worst) = (0, 0.0f32);
        for (i, pixel) in picture.color.iter().enumerate() {
            let ndc = [i as u32 % 48, i as u32 / 48].map(|k| 2.0 * (k as f32 + 0.5) / 48.0 - 1.0);
            let ray = z + x * ndc[0] + y * ndc[1];
            let at = camera.position + ray * (-camera.position.y / ray.y) - MIDDLE;
            let upright = Vec2::new(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.z);
            if upright.min_element() < 0.05 || upright.max_element() > 0.95 {
                continue;
            }
            let sets = [upright, Vec2::new(upright.y, 1.0 - upright.x)];
            let texcoord = transform.transform_point2(sets[coordinates as usize]);
            let color = Vec2::new(beyond(texcoord.x), beyond(texcoord.y)) + sets[1 - coordinates as usize];
            seen += 1;
            worst = worst.max((pixel[0] - color.x).abs()).max((pixel[1] - color.y).abs());
        }
        println!("set {coordinates}, {wrap:?}: {seen} pixels, worst difference {worst:.4}");
        assert!(seen > 500 && worst < 0.03, "{worst}");
    }
}

/// The back of a one-sided material is invisible but casts its shadow; that of a two-sided one is visible.
#[test]
fn back_faces_show_for_double_sided_materials() {
    let Some(gpu) = test_gpu() else { return };
    let behind = Camera::looking_at(MIDDLE + 5.0 * Vec3::Y, MIDDLE, 30.0);
    for (double_sided, mirrored) in [(false, false), (true, false), (false, true)] {
        let mut model = square(Material { double_sided, ..matte(0.5) });
        if mirrored {
            model.nodes[0].transform = Transform::Matrix(Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
        }
        let seen = |camera| drawn(&gpu, model.clone(), camera, None, &settings(1, Technique::Leadr)).mean(3);
        let (front, back) = (seen(facing(5.0)), seen(behind));
        println!("double-sided {double_sided}, mirrored {mirrored}: front {front:.3}, back {back:.3}");
        assert!(front > 0.5 && if double_sided { back > 0.5 } else { back == 0.0 });
    }
}

/// Lamps of a file light a matte square as specified by `KHR_lights_punctual`.
#[test]
fn lights_of_a_file_follow_their_closed_forms() {
    let Some(gpu) = test_gpu() else { return };
    let kinds = [
        ("point", LightKind::Point, None),
        ("fading point", LightKind::Point, Some(4.0)),
        ("spot", LightKind::Spot { inner_angle: 0.2, outer_angle: 0.5 }, None),
        ("directional", LightKind::Directional, None),
    ];
    let (albedo, away, intensity) = (0.6, 2.5f32, 3.0f32);
    for (name, kind, range) in kinds {
        let mut model = square(matte(albedo));
        model.lights = vec![Light { name: name.into(), color: [1.0, 0.5, 0.25], intensity, kind, range }];
        model.nodes.push(Node {
            light: Some(0),
            ..node(Transform::Matrix(Mat4::from_translation(Vec3::new(0.0, 0.0, away))))
        });
        model.order.push(1);
        model.scenes[0].roots.push(1);
        let camera = facing(5.0);
        let settings = settings(1, Technique::Leadr);
        let picture = drawn(&gpu, model, camera, None, &settings);
        let [x, y, z] = camera.rays(settings.size, Vec2::ZERO);
        let (mut seen, mut worst, mut peak) = (0, 0.0f32, 0.0f32);
        for (i, pixel) in picture.color.iter().enumerate() {
            let ndc = [i as u32 % 48, i as u32 / 48].map(|k| 2.0 * (k as f32 + 0.5) / 48.0 - 1.0);
            let ray = z + x * ndc[0] + y * ndc[1];
            let at = camera.position + ray * (-camera.position.y / ray.y) - MIDDLE;
            if at.abs().max_element() > 0.95 {
                continue;
            }
            let distance = (at.length_squared() + away * away).sqrt();
            let cosine = away / distance;
            let fading = range.map_or(1.0, |range: f32| (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0));
            let cone = match kind {
                LightKind::Spot { inner_angle, outer_angle } => {
                    let part = (cosine - outer_angle.cos()) / (inner_angle.cos() - outer_angle.cos());
                    part.clamp(0.0, 1.0).powi(2)
                }
                _ => 1.0,
            };
            let irradiance = match kind {
                LightKind::Directional => intensity,
                _ => intensity * fading * cone * cosine / (distance * distance),
            };
            seen += 1;
            peak = peak.max(albedo * irradiance / PI);
            for (channel, part) in [1.0, 0.5, 0.25].into_iter().enumerate() {
                worst = worst.max((pixel[channel] - albedo * part * irradiance / PI).abs());
            }
        }
        println!("{name}: {seen} pixels, worst difference {worst:.5} of at most {peak:.3}");
        // The fitted facet integral has an error of 0.6 % for light from the viewer.
        assert!(seen > 500 && worst < 0.01 * peak, "{name}: {worst} of {peak}");
    }
}

/// Many lights of a file are drawn at their places, in their colours and units: candela, and lux for directional lights. All directional
/// lights are parallel.
#[test]
fn many_lights_of_a_file_add_up() {
    let Some(gpu) = test_gpu() else { return };
    let albedo = 0.6;
    let mut model = square(matte(albedo));
    let spot = LightKind::Spot { inner_angle: 0.3, outer_angle: 0.7 };
    let kinds = [
        (LightKind::Directional, [1.0, 0.9, 0.8], 0.9),
        (LightKind::Directional, [0.2, 0.3, 1.0], 0.5),
        (LightKind::Directional, [0.0, 1.0, 0.0], 0.2),
        (LightKind::Point, [1.0, 0.0, 0.0], 0.8),
        (spot, [1.0, 1.0, 0.0], 2.0),
        (LightKind::Point, [0.3, 0.0, 1.0], 0.6),
        (spot, [0.0, 1.0, 1.0], 1.5),
        (LightKind::Point, [1.0, 0.4, 0.1], 0.4),
    ];
    let matrix = |i: usize| {
        let angle = i as f32;
        let place = Vec3::new(0.8 * angle.cos(), 0.8 * angle.sin(), 1.4 + 0.1 * angle);
        Mat4::from_translation(place) * Mat4::from_rotation_y(0.2 - 0.05 * angle)
    };
    for (i, (kind, color, intensity)) in kinds.into_iter().enumerate() {
        model.lights.push(Light { name: format!("light {i}"), color, intensity, kind, range: None });
        model.nodes.push(Node { light: Some(i), ..node(Transform::Matrix(matrix(i))) });
        model.order.push(i + 1);
        model.scenes[0].roots.push(i + 1);
    }
    let camera = facing(5.0);
    let settings = settings(1, Technique::Leadr);
    let picture = drawn(&gpu, model, camera, None, &settings);
    let [x, y, z] = camera.rays(settings.size, Vec2::ZERO);
    let (mut seen, mut worst) = (0, 0.0f32);
    for (i, pixel) in picture.color.iter().enumerate() {
        let ndc = [i as u32 % 48, i as u32 / 48].map(|k| 2.0 * (k as f32 + 0.5) / 48.0 - 1.0);
        let ray = z + x * ndc[0] + y * ndc[1];
        let at = camera.position + ray * (-camera.position.y / ray.y) - MIDDLE;
        if at.abs().max_element() > 0.95 {
            continue;
        }
        // In the coordinates of the file, y is up.
        let at = Vec3::new(at.x, at.z, 0.0);
        let mut expected = Vec3::ZERO;
        for (i, (kind, color, intensity)) in kinds.into_iter().enumerate() {
            let axis = matrix(i).transform_vector3(Vec3::NEG_Z);
            let away = matrix(i).w_axis.truncate() - at;
            let (square, towards) = (away.length_squared(), away.normalize());
            let irradiance = match kind {
                LightKind::Directional => -axis.z,
                LightKind::Point => towards.z / square,
                LightKind::Spot { inner_angle, outer_angle } => {
                    let part = (axis.dot(-towards) - outer_angle.cos()) / (inner_angle.cos() - outer_angle.cos());
                    part.clamp(0.0, 1.0).powi(2) * towards.z / square
                }
            };
            expected += Vec3::from(color) * (intensity * irradiance * albedo / PI);
        }
        seen += 1;
        worst = worst.max(((Vec3::new(pixel[0], pixel[1], pixel[2]) - expected) / expected).abs().max_element());
    }
    println!("{seen} pixels, worst relative difference {worst:.4}");
    assert!(seen > 500 && worst < 0.012, "{worst}");
}

/// A square that is lit by one light of a file, `metres` in front of it. Rotated, a directional light stands 60° high.
fn lit_square(kind: LightKind, intensity: f32, metres: f32) -> Model {
    let mut model = square(matte(0.18));
    model.lights = vec![Light { name: "light".into(), color: [1.0; 3], intensity, kind, range: None }];
    let matrix = Mat4::from_translation(Vec3::Z * metres) * Mat4::from_rotation_x(-60f32.to_radians());
    model.nodes.push(Node { light: Some(0), ..node(Transform::Matrix(matrix)) });
    model.order.push(1);
    model.scenes[0].roots.push(1);
    model
}

/// A sun of any strength replaces the sky's, is as bright, and moves the sky's sun. Without it, the sky's sun shines.
#[test]
fn suns_of_a_file_are_exposed_like_the_skys() {
    for intensity in [0.01, 3.0, 683.0, 120_000.0] {
        let mut stage = stage_of(lit_square(LightKind::Directional, intensity, 0.0));
        let toward = stage.sun_of_sky().unwrap();
        assert!((toward - Vec3::new(0.0, -0.5, 0.75f32.sqrt())).length() < 1e-5, "{toward}");
        let sky = Sky { sun_direction: toward, ..Sky::default() };
        let state = stage.state(0.0, &facing(5.0), &Lights::under(&sky));
        let brightness = |sun: Sun| luminance(sun.irradiance.as_dvec3());
        let (own, of_sky) = (state.sun().unwrap(), Sun::of(&sky));
        assert!((brightness(own) / brightness(of_sky) - 1.0).abs() < 1e-5 && own.irradiance.x == own.irradiance.z);
        assert!((own.direction - toward).length() < 1e-5 && state.point_lights.is_empty());
        assert_eq!(state.exposure(), exposure(&sky));
        stage.leave_out_own_sun();
        let state = stage.state(0.0, &facing(5.0), &Lights::under(&sky));
        assert!(state.sun() == Some(of_sky) && stage.sun_of_sky().is_none());
        assert_eq!(state.exposure(), exposure(&sky), "a sun that is left out adds no light");
    }
    let level = Model { nodes: vec![node(Transform::IDENTITY); 2], ..lit_square(LightKind::Directional, 3.0, 0.0) };
    let mut model = level;
    (model.nodes[0].mesh, model.nodes[1].light) = (Some(0), Some(0));
    let toward = stage_of(model).sun_of_sky().unwrap();
    assert!((toward.z.asin().to_degrees() - 20.0).abs() < 1e-3 && toward.y < 0.0, "{toward}");
}

/// Grey is grey under the sky and lamps of any strength: the exposure makes up for the light that they add.
#[test]
fn lamps_of_a_file_do_not_overexpose() {
    let sky = Sky::default();
    for (candela, added) in [(0.0, 0.0), (3.0, 0.153), (54_000.0, 1.0)] {
        let stage = stage_of(lit_square(LightKind::Point, candela, 2.5));
        let state = stage.state(0.0, &facing(5.0), &Lights::under(&sky));
        assert!((state.added_light - added).abs() < 0.01, "{candela}: {}", state.added_light);
        assert_eq!(state.exposure(), exposure(&sky) / (1.0 + state.added_light));
        let reaching: f32 = state.point_lights.iter().map(|lamp| lamp.intensity.x / (2.5 * 2.5)).sum();
        assert!((reaching * exposure(&sky) - PI * added).abs() < 0.02 * PI, "{candela}: {reaching}");
        assert!(state.sun() == Some(Sun::of(&sky)));
    }
}

/// Ground is drawn below a model unless the model has a floor, and a floor on the ground lies above the soil.
#[test]
fn a_model_with_a_floor_has_no_other_ground() {
    let upright = |at: Vec3, size: f32| Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(size));
    let level = |at: Vec3, size: f32| upright(at, size) * Mat4::from_rotation_x(-0.5 * PI);
    let of = |nodes: &[Mat4], ground: Ground| {
        let nodes: Vec<Node> =
            nodes.iter().map(|&matrix| Node { mesh: Some(0), ..node(Transform::Matrix(matrix)) }).collect();
        let all: Vec<usize> = (0..nodes.len()).collect();
        let scenes = vec![SceneRoots { name: String::new(), roots: all.clone() }];
        let model = Model { nodes, order: all, scenes, ..square(matte(0.5)) };
        let stage = stage(ModelChoice::new(model, None).unwrap().on(ground)).unwrap();
        let state = stage.state(0.0, &facing(5.0), &Lights::default());
        let Pose::Vertices(vertices) = &state.poses[0] else { panic!("a posed model") };
        let lowest = vertices.positions.iter().map(|p| p.z).fold(f32::MAX, f32::min);
        assert_eq!(state.poses.len(), stage.objects.len());
        (stage.objects.len() == 2, lowest)
    };
    let (floor, card, shelf) = (level(Vec3::ZERO, 3.0), upright(Vec3::Y, 1.0), level(Vec3::new(0.0, 2.0, 0.0), 3.0));
    assert_eq!(of(&[card], Ground::Auto), (true, 0.0));
    assert_eq!(of(&[card], Ground::Off), (false, 0.0));
    assert!(!of(&[floor, card], Ground::Auto).0);
    let (is_drawn, lowest) = of(&[floor, card], Ground::On);
    assert!(is_drawn && lowest > 0.05, "{lowest}");
    assert!(of(&[card, shelf], Ground::Auto).0, "a shelf is no floor");
    assert!(of(&[level(Vec3::ZERO, 0.4), card], Ground::Auto).0, "a base is no floor");
    assert!(of(&[floor], Ground::Auto).0, "a flat model lies on the ground");
    assert!(of(&[floor * Mat4::from_rotation_x(PI), card], Ground::Auto).0, "a ceiling at the bottom is no floor");
}

/// A file's camera has the correct view: the square ends at its angle, and an orthographic view has its width in metres.
#[test]
fn file_cameras_match_their_description() {
    let Some(gpu) = test_gpu() else { return };
    let perspective = Projection::Perspective { vertical_angle: 2.0 * 0.5f32.atan(), aspect: None };
    let parallel = Projection::Orthographic { half_width: 2.0, half_height: 2.0 };
    for (projection, side) in [(perspective, 0.5f64), (parallel, 0.5)] {
        let mut model = square(Material { double_sided: true, ..matte(0.5) });
        model.cameras = vec![models::Camera { name: "eye".into(), projection, near: 0.1, far: None }];
        model.nodes.push(Node {
            camera: Some(0),
            ..node(Transform::Matrix(Mat4::from_translation(Vec3::new(0.0, 0.0, 4.0))))
        });
        model.order.push(1);
        model.scenes[0].roots.push(1);
        let choice = ModelChoice::new(model.clone(), None).unwrap();
        let error = choice.clone().seen_by(Some("moon")).unwrap_err().to_string();
        assert_eq!(error, "no camera is named moon; available: 1 eye");
        let choice = choice.seen_by(Some("eye")).unwrap();
        assert_eq!(choice.camera, Some(1));
        let camera = (stage(choice).unwrap().own_camera.unwrap())(0.0);
        let share = drawn(&gpu, model, camera, None, &settings(16, Technique::Leadr)).mean(3);
        println!("{projection:?}: {share:.4}");
        assert!((share.sqrt() - side).abs() < 0.01, "{share}");
    }
}
