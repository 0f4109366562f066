//! Occlusion cones on spheres and models, against closed forms and against the plane.

use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};
use leadr::maps::HeightMap;
use leadr::maps::RgbImage;
use leadr::maps::material::{Encoding, Input, Material, Raster, Relief, Samples, Texture};
use leadr::models::{Mesh, Model, Node, Primitive, SceneRoots, Transform};
use leadr::reflectance::masking::occlusion::{Cone, ConeEdge, cone_light_by_edge};
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::scene::{FrameState, Object, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique, Terms};
use leadr::render::surfaces::atlas::frames::orthonormal;
use leadr::scenes::dressed;
use leadr::scenes::model::{ModelChoice, stage};
use leadr::scenes::stage::Lights;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::in_room;
use leadr_tools::metrics::compare::rrmse;

/// A cone whose components are codes of 8 bits. It leans along s and up.
const BENT: [f32; 4] = [38.0 / 127.0, 19.0 / 127.0, 51.0 / 127.0, 70.0 / 127.0];
/// A cone of half angle 90°, which hides nothing.
const OPEN: [f32; 4] = [0.0, 0.0, 1.0, 1.0];
/// Cones of this picture width lean in all directions.
const MANY: u32 = 8;

fn cones_of(size: u32, cone: impl Fn(u32, u32) -> [f32; 4]) -> Texture {
    // Directions are stored from 0 to 1.
    let stored = |[x, y, z, open]: [f32; 4]| [0.5 + 0.5 * x, 0.5 + 0.5 * y, 0.5 + 0.5 * z, open];
    let texels = (0..size * size).flat_map(|i| stored(cone(i % size, i / size)));
    let raster = Raster::new(size, size, 4, Samples::F32(texels.collect())).unwrap();
    Texture::new(raster, "cones", Encoding::Linear)
}

/// Smooth cones that lean in all directions.
fn many() -> Texture {
    cones_of(MANY, |x, y| {
        let [s, t] = [x, y].map(|k| std::f32::consts::TAU * (k as f32 + 0.5) / MANY as f32);
        [0.35 * s.sin(), 0.3 * (t + 0.7).cos(), 0.45, 0.6 + 0.1 * (s + t).sin()]
    })
}

/// The cones of a picture seen in a mirror.
fn mirrored(cones: &Texture) -> Texture {
    let value = |x, y, channel| cones.raster.value(x, y, channel);
    cones_of(cones.raster.width(), |x, y| {
        let x = cones.raster.width() - 1 - x;
        [1.0 - 2.0 * value(x, y, 0), 2.0 * value(x, y, 1) - 1.0, 2.0 * value(x, y, 2) - 1.0, value(x, y, 3)]
    })
}

fn grey(cones: Option<Texture>) -> Material {
    let (base_color, roughness) = (Input::constant([0.5; 3]), Input::constant(0.6));
    Material { base_color, roughness, cones, ..Material::new("grey") }
}

fn sphere(cones: Option<Texture>, repeat: Option<f32>, tile: u32) -> Object {
    dressed::sphere_stage(&grey(cones), repeat, tile).objects.remove(0)
}

fn plane(cones: Option<Texture>, repeat: f32) -> Object {
    dressed::plane_stage(&grey(cones), Some(repeat)).objects.remove(0)
}

/// Texture coordinates of the corners of the square: upright, mirrored, and rotated by a quarter turn.
const UPRIGHT: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
const MIRRORED: [[f32; 2]; 4] = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]];
const ROTATED: [[f32; 2]; 4] = [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]];

/// A model: a square of two metres that faces -y, with its top towards +z.
struct Square {
    object: Object,
    pose: Pose,
    middle: Vec3,
}

fn square(material: Material, sets: &[[[f32; 2]; 4]]) -> Square {
    let primitive = Primitive {
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        texcoords: sets.iter().map(|set| set.to_vec()).collect(),
        ..Primitive::default()
    };
    let node = Node {
        name: String::new(),
        parent: None,
        children: Vec::new(),
        transform: Transform::IDENTITY,
        mesh: Some(0),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
        visible: true,
    };
    let model = Model {
        name: "square".into(),
        scenes: vec![SceneRoots { name: String::new(), roots: vec![0] }],
        nodes: vec![node],
        order: vec![0],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        materials: vec![Material { double_sided: true, ..material }],
        ..Model::default()
    };
    let mut stage = stage(ModelChoice::new(model, None).unwrap()).unwrap();
    let pose = stage.state(0.0, &Camera::looking_at(-4.0 * Vec3::Y, Vec3::ZERO, 30.0), &Lights::default());
    let object = stage.objects.swap_remove(0);
    let positions = &object.mesh.positions;
    let middle = positions.iter().sum::<Vec3>() / positions.len() as f32;
    Square { pose: pose.poses[0].clone(), object, middle }
}

fn settings(technique: Technique, size: u32, options: ShadingOptions) -> RenderSettings {
    let shading = technique.with(ShadingOptions { shadowing: Shadowing::Smith, ..options });
    RenderSettings { size: (size, size), shading, shadows: false, ..Default::default() }
}

/// Returns the part of a sun's diffuse light that the cone in the middle of the picture lets through.
fn passed(renderer: &mut Renderer, pose: &Pose, camera: Camera, sun: Vec3) -> f64 {
    let camera = Camera { up: (camera.position - camera.target).any_orthogonal_vector(), ..camera };
    let sun = Some(Sun { direction: sun, irradiance: Vec3::ONE });
    let state = FrameState { sun, ..FrameState::new(camera, vec![pose.clone()]) };
    let [soft, open] = [ConeEdge::Soft, ConeEdge::Open].map(|cone_edge| {
        let options = ShadingOptions { terms: Terms::DIFFUSE_LIGHTS, cone_edge, ..Default::default() };
        let color = renderer.render(&state, &settings(Technique::Leadr, 9, options)).unwrap().color;
        f64::from(color[40][0])
    });
    assert!(open > 0.02, "the sun lights the middle: {open}");
    soft / open
}

/// Returns the part of a sun's light within the cone of a direction, which is a vector of the world.
fn expected(open: Vec3, sun: Vec3) -> f64 {
    cone_light_by_edge(ConeEdge::Soft, &Cone::of_vector(open.as_dvec3()), sun.as_dvec3())
}

/// The cone of [`BENT`] along these directions of s and t, and this normal.
fn bent(s: Vec3, t: Vec3, normal: Vec3) -> Vec3 {
    BENT[0] * s - BENT[1] * t + BENT[2] * normal
}

/// On all sides of a sphere, near and from a distance where a pixel is as wide as a patch, cones lean along the projection of the material.
#[test]
fn cones_of_a_sphere_lean_along_its_material() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = in_room(&gpu, vec![sphere(Some(cones_of(1, |_, _| BENT)), None, 16)], [0.0; 3]);
    let mut turned_away = 0.0f64;
    for (axis, s, t) in [
        (Vec3::X, Vec3::Y, Vec3::NEG_Z),
        (Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z),
        (Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z),
        (Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z),
        (Vec3::Z, Vec3::X, Vec3::NEG_Y),
        (Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y),
    ] {
        for lean in [Vec2::ZERO, Vec2::new(0.35, 0.2)] {
            let normal = (axis + lean.x * s + lean.y * t).normalize();
            let [a, b] = orthonormal([s, t].map(|axis| axis.reject_from_normalized(normal)));
            let near = [a, -a, b, -b].map(|along| (along, 3.0, 4.0, 0.02));
            let far = [-a, b].map(|along| (along, 8.0, 6.5, 0.04));
            for (along, distance, degrees, most) in near.into_iter().chain(far) {
                let sun = (normal + along).normalize();
                let camera = Camera::looking_at(normal * distance, Vec3::ZERO, degrees);
                let found = passed(&mut renderer, &Pose::REST, camera, sun);
                let want = expected(bent(a, b, normal), sun);
                println!("{axis} {lean}, from {distance} m: {found:.3}, expected {want:.3}");
                assert!((found - want).abs() < most, "{axis} {lean} {distance}: {found} {want}");
                let about_normal = expected(normal * Vec3::from_slice(&BENT).length(), sun);
                turned_away = turned_away.max((want - about_normal).abs());
            }
        }
    }
    assert!(turned_away > 0.2, "{turned_away}");
}

/// A sphere that turns takes its cones along.
#[test]
fn cones_turn_with_a_sphere() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = in_room(&gpu, vec![sphere(Some(cones_of(1, |_, _| BENT)), None, 16)], [0.0; 3]);
    let turn = Quat::from_rotation_z(1.1) * Quat::from_rotation_x(0.6);
    let pose = Pose::Rigid(Affine3A::from_quat(turn));
    let [s, t, normal] = [Vec3::X, Vec3::NEG_Y, Vec3::Z].map(|axis| turn * axis);
    for along in [s, -s, t, -t] {
        let sun = (normal + along).normalize();
        let camera = Camera::looking_at(normal * 3.0, Vec3::ZERO, 4.0);
        let (found, want) = (passed(&mut renderer, &pose, camera, sun), expected(bent(s, t, normal), sun));
        assert!((found - want).abs() < 0.02, "{along}: {found} {want}");
    }
}

/// A picture of a surface with all terms of the light, under a sun and a grey environment.
fn picture(gpu: &TestGpu, object: Object, pose: &Pose, camera: Camera, sun: Vec3) -> RgbImage {
    let sun = Some(Sun { direction: sun, irradiance: Vec3::splat(3.0) });
    let state = FrameState { sun, ..FrameState::new(camera, vec![pose.clone()]) };
    let mut renderer = in_room(gpu, vec![object], [0.5; 3]);
    let color = renderer.render(&state, &settings(Technique::Gloss, 24, ShadingOptions::default())).unwrap().color;
    RgbImage::new(24, 24, color.iter().map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()).unwrap()
}

/// Where a part of a sphere is small enough to be flat, it looks like the plane.
#[test]
fn a_large_sphere_looks_like_the_plane() {
    let Some(gpu) = test_gpu() else { return };
    // The top of the sphere is projected along z, which shifts the images by .71 of a repeat.
    let (repeat, shift) = (0.1, 0.71);
    let sun = Vec3::new(0.5, -0.4, 0.7).normalize();
    let at = |target: Vec3| Camera::looking_at(target + Vec3::new(0.0, -0.02, 1.0), target, 3.0);
    let on_plane = at(shift * repeat * Vec3::new(1.0, -1.0, 0.0));
    let flat = picture(&gpu, plane(Some(many()), repeat), &Pose::REST, on_plane, sun);
    let round = picture(&gpu, sphere(Some(many()), Some(repeat), 64), &Pose::REST, at(Vec3::Z), sun);
    let even = picture(&gpu, sphere(None, Some(repeat), 64), &Pose::REST, at(Vec3::Z), sun);
    let [round, even] = [round, even].map(|seen| rrmse(&flat, &seen).unwrap());
    println!("relative RMSE {round:.4}, without cones {even:.4}");
    assert!(round < 0.05 && even > 0.2, "{round} {even}");
}

/// A square of a model looks like the plane, with upright and with mirrored texture coordinates.
#[test]
fn a_square_looks_like_the_plane() {
    let Some(gpu) = test_gpu() else { return };
    // The rotation from the plane to the square.
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let (sun, eye) = (Vec3::new(0.5, -0.4, 0.7).normalize(), Vec3::new(0.3, -0.9, 3.0));
    // The middle of a repeat of the plane is the middle of the square.
    let middle = Vec3::new(1.0, -1.0, 0.0);
    let flat =
        picture(&gpu, plane(Some(many()), 2.0), &Pose::REST, Camera::looking_at(middle + eye, middle, 25.0), sun);
    let seen = |cones: Texture, set| {
        let Square { object, pose, middle } = square(grey(Some(cones)), &[set]);
        let camera = Camera { up: upright * Vec3::Z, ..Camera::looking_at(middle + upright * eye, middle, 25.0) };
        rrmse(&flat, &picture(&gpu, object, &pose, camera, upright * sun)).unwrap()
    };
    for (cones, set) in [(many(), UPRIGHT), (mirrored(&many()), MIRRORED)] {
        let error = seen(cones, set);
        println!("relative RMSE {error:.5}");
        assert!(error < 1e-4, "{error}");
    }
    // The same cones on mirrored coordinates lean the other way.
    let error = seen(many(), MIRRORED);
    assert!(error > 0.03, "{error}");
}

/// Cones follow the coordinates of their own chart, the other side of a surface, and the projection of heights without coordinates.
#[test]
fn cones_of_models_follow_their_coordinates() {
    let Some(gpu) = test_gpu() else { return };
    let (right, up, normal) = (Vec3::X, Vec3::Z, Vec3::NEG_Y);
    let cones = || cones_of(1, |_, _| BENT);
    let charted = Material {
        base_color: Input::colors(cones_of(1, |_, _| [0.0; 4])),
        cones: Some(Texture { coordinates: 1, ..cones() }),
        ..grey(None)
    };
    let map = HeightMap { width: 1, height: 1, texels: vec![0.0] };
    let relief = Some(Relief { map, scale: Some(0.01), in_widths: false, middle: 0.0 });
    let projected = Material { relief, ..grey(Some(cones())) };
    let squares = [
        ("upright", square(grey(Some(cones())), &[UPRIGHT]), right, -up),
        ("mirrored", square(grey(Some(cones())), &[MIRRORED]), -right, -up),
        // On the rotated coordinates, s points down and t to the left.
        ("charted", square(charted, &[UPRIGHT, ROTATED]), -up, -right),
        ("projected", square(projected, &[]), right, -up),
    ];
    for (name, Square { object, pose, middle }, s, t) in squares {
        let mut renderer = in_room(&gpu, vec![object], [0.0; 3]);
        for side in [1.0, -1.0] {
            // Seen from behind, the cone is mirrored in the point, like the normal of a bump that has become a pit.
            let open = side * bent(s, t, normal);
            for along in [right, -right, up, -up] {
                let sun = (side * normal + along).normalize();
                let camera = Camera::looking_at(middle + side * 3.0 * normal, middle, 2.0);
                let (found, want) = (passed(&mut renderer, &pose, camera, sun), expected(open, sun));
                assert!((found - want).abs() < 0.015, "{name} {side} {along}: {found} {want}");
            }
        }
    }
}

/// Cones of half angle 90° change nothing, on the plane, on a sphere and on a model.
#[test]
fn open_cones_change_nothing() {
    let Some(gpu) = test_gpu() else { return };
    let sun = Vec3::new(0.4, -0.6, 0.7).normalize();
    let open = || Some(cones_of(1, |_, _| OPEN));
    let eye = Vec3::new(0.5, -3.0, 1.0);
    let of = |[without, with]: [Object; 2], pose: &Pose, middle: Vec3| {
        let camera = Camera::looking_at(middle + eye, middle, 45.0);
        let [a, b] = [without, with].map(|object| picture(&gpu, object, pose, camera, sun));
        let apart = a.texels.iter().flatten().zip(b.texels.iter().flatten()).map(|(a, b)| (a - b).abs());
        let (worst, brightest) = (apart.fold(0.0, f32::max), a.texels.iter().flatten().fold(0.0f32, |m, v| m.max(*v)));
        assert!(brightest > 0.3 && worst < 0.01, "{worst} of {brightest}");
    };
    of([plane(None, 2.0), plane(open(), 2.0)], &Pose::REST, Vec3::ZERO);
    of([sphere(None, None, 16), sphere(open(), None, 16)], &Pose::REST, Vec3::ZERO);
    let [without, with] = [None, open()].map(|cones| square(grey(cones), &[UPRIGHT]));
    of([without.object, with.object], &without.pose, without.middle);
}

/// A material without cones keeps its scalar occlusion beside a material with cones, with and without edge samples.
#[test]
fn materials_without_cones_keep_their_occlusion() {
    let Some(gpu) = test_gpu() else { return };
    let raster = Raster::new(1, 1, 1, Samples::U8(vec![90])).unwrap();
    let occluded =
        Material { occlusion: Input::texture(Texture::new(raster, "occlusion", Encoding::Linear), 0), ..grey(None) };
    let Square { object, pose, middle } = square(occluded, &[UPRIGHT]);
    let camera = Camera::looking_at(middle - 3.0 * Vec3::Y, middle, 20.0);
    let away = Pose::Rigid(Affine3A::from_translation(Vec3::new(0.0, -20.0, 0.0)));
    let drawn = |cones: Option<Texture>, edge_samples| {
        let state = FrameState::new(camera, vec![pose.clone(), away.clone()]);
        let mut renderer = in_room(&gpu, vec![object.clone(), plane(cones, 2.0)], [1.0; 3]);
        let options = ShadingOptions { terms: Terms::DIFFUSE_ENVIRONMENT, edge_samples, ..Default::default() };
        let color = renderer.render(&state, &settings(Technique::Leadr, 9, options)).unwrap().color;
        DVec3::from_array([0, 1, 2].map(|channel| f64::from(color[40][channel])))
    };
    for edge_samples in [1, 4] {
        let [alone, beside] = [None, Some(cones_of(1, |_, _| BENT))].map(|cones| drawn(cones, edge_samples));
        assert!(alone.x > 0.05 && (alone - beside).abs().max_element() < 1e-4, "{edge_samples}: {alone} {beside}");
    }
}
