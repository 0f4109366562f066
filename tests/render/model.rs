//! glTF models as scenes.

use glam::{Quat, Vec2, Vec3};
use leadr::maps::material::{
    Encoding, GreenAxis, Input, Material, MaterialDetail, NormalMap, Raster, Samples, Texture,
};
use leadr::models::{LoadOptions, Mesh, Model, Node, Primitive, SceneRoots, Transform};
use leadr::render::camera::Camera;
use leadr::render::light::sky::Sky;
use leadr::render::settings::{RenderSettings, Technique};
use leadr::scenes::model::{ModelChoice, stage};
use leadr::scenes::stage::Lights;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::stage_under_sky;
use leadr_testing::shared::shared_data;

/// Linear colour at a texture position: red grows to the right, green downwards.
fn color(s: f32, t: f32) -> [f32; 2] {
    [s, t]
}

/// A square of two metres in the plane z = 0 of a node rotated about y, with a texture of two ramps.
fn square(mirrored: bool) -> Model {
    let size = 64;
    let codes = (0..size * size).flat_map(|i| {
        let [s, t] = [i % size, i / size].map(|k| (k as f32 + 0.5) / size as f32);
        let [r, g] = color(s, t).map(|v| (v * 255.0 + 0.5) as u8);
        [r, g, 0]
    });
    let raster = Raster::new(size, size, 3, Samples::U8(codes.collect())).unwrap();
    let mut material = Material::new("ramps");
    material.base_color = Input::colors(Texture::new(raster, "ramps", Encoding::Linear));
    material.double_sided = true;
    let primitive = Primitive {
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        texcoords: vec![vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]],
        ..Primitive::default()
    };
    let node = Node {
        name: "square".into(),
        parent: None,
        children: Vec::new(),
        transform: Transform::Parts {
            translation: Vec3::ZERO,
            rotation: Quat::from_rotation_y(0.3),
            scale: if mirrored { Vec3::new(-1.0, 1.0, 1.0) } else { Vec3::ONE },
        },
        mesh: Some(0),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
        visible: true,
    };
    Model {
        name: "square".into(),
        scenes: vec![SceneRoots { name: String::new(), roots: vec![0] }],
        nodes: vec![node],
        order: vec![0],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        materials: vec![material],
        ..Model::default()
    }
}

/// Every pixel of a textured square has the colour at its ray's intersection, seen from the front and from behind, mirrored or not.
#[test]
fn textures_follow_their_coordinates() {
    let Some(gpu) = test_gpu() else { return };
    for (mirrored, behind) in [(false, false), (false, true), (true, false)] {
        let mut stage = stage(ModelChoice::new(square(mirrored), None).unwrap()).unwrap();
        let top = stage.objects[0].mesh.positions.iter().map(|p| p.z).fold(0.0, f32::max);
        // The square after its node transform, in z-up coordinates with the front along -y.
        let (sine, cosine) = 0.3f32.sin_cos();
        let middle = Vec3::new(0.0, 0.0, 0.5 * top);
        let (right, up) = (Vec3::new(cosine, sine, 0.0), Vec3::Z);
        assert!((top - 2.0).abs() < 1e-5);
        let outward = right.cross(up) * if behind { -1.0 } else { 1.0 };
        let camera = Camera::looking_at(middle + 6.0 * outward + Vec3::new(0.7, 0.0, 0.4), middle, 28.0);
        let mut renderer = stage_under_sky(&gpu, &mut stage, 16);
        let state = stage.state(0.0, &camera, &Lights::under(&Sky::default()));
        let (width, height) = (64u32, 48u32);
        let settings = RenderSettings {
            size: (width, height),
            samples: 1,
            shading: Technique::Constant.into(),
            ..RenderSettings::default()
        };
        let output = renderer.render(&state, &settings).unwrap();
        let [x, y, z] = camera.rays((width, height), Vec2::ZERO);
        let (mut seen, mut worst) = (0, 0.0f32);
        for (i, pixel) in output.color.iter().enumerate() {
            let ndc = [i as u32 % width, i as u32 / width].map(|k| k as f32 + 0.5);
            let ray = z + x * (2.0 * ndc[0] / width as f32 - 1.0) + y * (2.0 * ndc[1] / height as f32 - 1.0);
            let along = (middle - camera.position).dot(outward) / ray.dot(outward);
            let at = camera.position + ray * along - middle;
            let (s, t) = (0.5 + 0.5 * at.dot(right), 0.5 - 0.5 * at.dot(up));
            let s = if mirrored { 1.0 - s } else { s };
            // Away from the rim, where pixels also cover the ground and textures repeat.
            if !(0.06..0.94).contains(&s) || !(0.06..0.94).contains(&t) {
                continue;
            }
            seen += 1;
            let want = color(s, t);
            worst = worst.max((pixel[0] - want[0]).abs()).max((pixel[1] - want[1]).abs());
        }
        println!("mirrored {mirrored}, behind {behind}: {seen} pixels, worst difference {worst:.4}");
        // Half a colour code, and the codes of the sRGB mip levels.
        assert!(seen > 400 && worst < 0.012, "{worst}");
    }
}

/// A detail with one repeat is drawn like a normal map of the material, on plain and mirrored charts. Turned or repeated, it differs.
#[test]
fn a_detail_over_a_model_lies_like_its_normal_map() {
    let Some(gpu) = test_gpu() else { return };
    let size = 64;
    let codes = (0..size * size).flat_map(|i| {
        let [s, t] = [i % size, i / size].map(|k| (k as f32 + 0.5) / size as f32 * std::f32::consts::TAU);
        [0.4 * s.sin(), 0.3 * (2.0 * t + s).cos(), 0.85].map(|v| (127.5 * (1.0 + v) + 0.5) as u8)
    });
    let raster = Raster::new(size, size, 3, Samples::U8(codes.collect())).unwrap();
    let texture = Texture::new(raster, "waves", Encoding::Linear);
    let waves = NormalMap { texture, green: GreenAxis::Up, scale: 1.0 };
    let detail = |repeat: f32, rotation: f32| {
        let material = Material { normal_map: Some(waves.clone()), ..Material::new("detail") };
        let layer = MaterialDetail {
            material,
            colored: false,
            repeat,
            rotation,
            height_scale: 1.0,
            displaces: false,
            mask: None,
        };
        Some(Box::new(layer))
    };
    for mirrored in [false, true] {
        let draw = |change: &dyn Fn(&mut Material)| {
            let mut model = square(mirrored);
            model.materials[0].base_color = Input::constant([0.5; 3]);
            change(&mut model.materials[0]);
            let mut stage = stage(ModelChoice::new(model, None).unwrap()).unwrap();
            let mut renderer = stage_under_sky(&gpu, &mut stage, 16);
            let state = stage.state(0.0, &stage.views.mid, &Lights::under(&Sky::default()));
            let settings = RenderSettings { size: (64, 48), samples: 1, ..RenderSettings::default() };
            renderer.render(&state, &settings).unwrap().color
        };
        let expected = draw(&|material| material.normal_map = Some(waves.clone()));
        let apart = |found: &[[f32; 4]]| {
            let sum =
                |f: &dyn Fn(f32, f32) -> f32| found.iter().zip(&expected).map(|(a, b)| f(a[1], b[1])).sum::<f32>();
            sum(&|a, b| (a - b).abs()) / sum(&|_, b| b)
        };
        let [same, turned, repeated, without] = [
            draw(&|material| material.detail = detail(1.0, 0.0)),
            draw(&|material| material.detail = detail(1.0, 90.0)),
            draw(&|material| material.detail = detail(3.0, 0.0)),
            draw(&|_| ()),
        ]
        .map(|picture| apart(&picture));
        println!(
            "mirrored {mirrored}: as a detail {same:.4}, turned {turned:.4}, repeated {repeated:.4}, without {without:.4}"
        );
        assert!(
            [turned, repeated, without].iter().all(|other| *other > 8.0 * same + 0.01),
            "{same} {turned} {repeated} {without}"
        );
    }
}

/// Nodes of one mesh are drawn as instances. The picture is that of nodes with copies of the mesh, which are drawn as separate objects.
#[test]
fn instances_look_like_copies() {
    let Some(gpu) = test_gpu() else { return };
    let mut copied = bumpy_rows();
    let mut shared = copied.clone();
    shared.nodes.iter_mut().for_each(|node| node.mesh = Some(0));
    // Equal materials would be joined. Without occlusion, its strength does not matter.
    let material = |i: u8| Material { occlusion_strength: 0.1 * f32::from(i), ..copied.materials[0].clone() };
    copied.materials = (0..5).map(material).collect();
    copied.meshes.iter_mut().enumerate().for_each(|(i, mesh)| mesh.primitives[0].material = i);
    let draw = |model: Model, instances: &[u32]| {
        let mut stage = stage(ModelChoice::new(model, None).unwrap()).unwrap();
        assert_eq!(stage.objects.iter().map(|object| object.instances).collect::<Vec<_>>(), instances);
        let mut renderer = stage_under_sky(&gpu, &mut stage, 16);
        let state = stage.state(0.0, &stage.views.mid, &Lights::under(&Sky::default()));
        let settings = RenderSettings { size: (96, 64), samples: 1, ..RenderSettings::default() };
        renderer.render(&state, &settings).unwrap().color
    };
    // The last object is the ground. One node is mirrored.
    let (one, many) = (draw(copied, &[1; 6]), draw(shared, &[4, 1, 1]));
    let worst = one.as_flattened().iter().zip(many.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst == 0.0, "{worst}");
}

/// Five nodes in different poses, each with a copy of a bumpy mesh.
fn bumpy_rows() -> Model {
    let side = 17u32;
    let at = |i: u32| [i % side, i / side].map(|k| k as f32 / (side - 1) as f32 - 0.5);
    let height = |[x, y]: [f32; 2]| 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
    let positions: Vec<[f32; 3]> = (0..side * side).map(|i| [at(i)[0], at(i)[1], height(at(i))]).collect();
    let normal = |i: u32| {
        let [x, y] = at(i);
        let slope = [0.9 * (9.0 * x).cos() * (7.0 * y).cos(), -0.7 * (9.0 * x).sin() * (7.0 * y).sin()];
        Vec3::new(-slope[0], -slope[1], 1.0).normalize().to_array()
    };
    let corner = |i: u32| i / (side - 1) * side + i % (side - 1);
    let cells = (0..(side - 1) * (side - 1)).map(corner);
    let primitive = Primitive {
        triangles: cells.flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]).collect(),
        normals: (0..side * side).map(normal).collect(),
        texcoords: vec![positions.iter().map(|p| [p[0] + 0.5, 0.5 - p[1]]).collect()],
        positions,
        ..Primitive::default()
    };
    let base = square(false);
    let node = |number: usize| {
        let i = number as f32;
        Node {
            transform: Transform::Parts {
                translation: Vec3::new(1.1 * i, 0.1 * i, -0.2 * i),
                rotation: Quat::from_rotation_y(0.3 * i),
                scale: if number == 2 { Vec3::new(-1.0, 1.3, 1.0) } else { Vec3::new(1.0, 1.0 + 0.1 * i, 0.7) },
            },
            mesh: Some(number),
            ..base.nodes[0].clone()
        }
    };
    Model {
        scenes: vec![SceneRoots { name: String::new(), roots: (0..5).collect() }],
        nodes: (0..5).map(node).collect(),
        order: (0..5).collect(),
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }; 5],
        ..base
    }
}

#[test]
fn animations_are_found_by_name() {
    let error = ModelChoice::new(square(false), Some("Walk")).unwrap_err().to_string();
    assert_eq!(error, "no animation is named Walk; available: none");
    let empty = Model { meshes: vec![Mesh::default()], ..square(false) };
    let error = stage(ModelChoice::new(empty, None).unwrap()).err().unwrap().to_string();
    assert!(error.contains("has no triangles"), "{error}");
}

/// Third-party creatures stand on the ground and walk; none is scaled, and nothing is missing.
#[test]
fn sample_creatures_walk() {
    let Some(gpu) = test_gpu() else { return };
    let Some(folder) = shared_data("creatures") else { return };
    for (file, animation) in [("fox/Fox.glb", "Run"), ("trex_quaternius/Trex.glb", "Armature|TRex_Walk")] {
        let model = Model::load(folder.join(file), LoadOptions::default()).unwrap();
        let names: Vec<String> = model.animations.iter().map(|a| a.name.clone()).collect();
        let choice = ModelChoice::new(model, Some(animation)).unwrap_or_else(|_| panic!("{file}: {names:?}"));
        let mut stage = stage(choice).unwrap();
        let low = stage.objects.iter().filter(|object| object.mesh.triangles).flat_map(|o| &o.mesh.positions);
        let low = low.map(|p| p.z).fold(f32::MAX, f32::min);
        assert!((-1e-3..0.3).contains(&low), "{file}: its lowest point is at {low}");
        let camera = stage.views.mid;
        let mut renderer = stage_under_sky(&gpu, &mut stage, 16);
        let settings = RenderSettings { size: (64, 48), samples: 1, ..RenderSettings::default() };
        let pictures = [0.0, 0.2].map(|time| {
            let state = stage.state(time, &camera, &Lights::under(&Sky::default()));
            renderer.render(&state, &settings).unwrap().color
        });
        assert!(pictures.iter().flatten().flatten().all(|v| v.is_finite()), "{file}");
        let moved = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a != b).count();
        println!("{file}: {moved} pixels moved");
        assert!(moved > 40, "{file}: {moved} pixels");
    }
}
