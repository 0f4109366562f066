//! Displaced triangles: no cracks at any seam, with displacement and shaded slopes that match their maps.

use std::path::Path;

use glam::{Affine2, Quat, Vec2, Vec3};
use leadr::maps::material::Material;
use leadr::models::{LoadOptions, Mesh, Model, Node, Primitive, SceneRoots, Transform};
use leadr::render::scene::FactorMap;
use leadr::scenes::model::{ModelChoice, stage};
use leadr::scenes::stage::Stage;
use leadr_lab::cracks::{self, Cracks, Search, rough_relief, roughened};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::shared::shared_data;

/// A model of primitives, each with its own material.
fn model(primitives: Vec<Primitive>) -> Model {
    let node = Node {
        name: "node".into(),
        parent: None,
        children: Vec::new(),
        transform: Transform::Parts { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE },
        mesh: Some(0),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
        visible: true,
    };
    let materials = (0..primitives.len()).map(|i| Material::new(format!("material {i}"))).collect();
    let primitives = (0..).zip(primitives).map(|(material, p)| Primitive { material, ..p }).collect();
    Model {
        name: "hard".into(),
        scenes: vec![SceneRoots { name: String::new(), roots: vec![0] }],
        nodes: vec![node],
        order: vec![0],
        meshes: vec![Mesh { primitives, ..Mesh::default() }],
        materials,
        ..Model::default()
    }
}

/// A growing list of triangles.
#[derive(Default)]
struct Soup {
    primitive: Primitive,
    texcoords: Vec<[f32; 2]>,
}

impl Soup {
    /// Adds a triangle with its own vertices.
    fn add(&mut self, corners: [Vec3; 3], normals: [Vec3; 3], texcoords: [[f32; 2]; 3]) {
        let first = self.primitive.positions.len() as u32;
        self.primitive.triangles.push([first, first + 1, first + 2]);
        self.primitive.positions.extend(corners.map(|p| p.to_array()));
        self.primitive.normals.extend(normals.map(|n| n.normalize_or(Vec3::Z).to_array()));
        self.texcoords.extend(texcoords);
    }

    /// Adds a quadrilateral with normals at its corners and a chart from `low` to `high`.
    fn quad(&mut self, p: [Vec3; 4], n: [Vec3; 4], low: [f32; 2], high: [f32; 2]) {
        let t = [low, [high[0], low[1]], high, [low[0], high[1]]];
        for k in [[0, 1, 2], [0, 2, 3]] {
            self.add(k.map(|i| p[i]), k.map(|i| n[i]), k.map(|i| t[i]));
        }
    }

    fn primitive(self) -> Primitive {
        Primitive { texcoords: vec![self.texcoords], ..self.primitive }
    }
}

/// A cube with hard edges; each face has its own chart, of another size, some mirrored.
fn cube(centre: Vec3) -> Primitive {
    let mut soup = Soup::default();
    for face in 0..6 {
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][face / 2] * if face % 2 == 0 { 1.0 } else { -1.0 };
        let a = [Vec3::Y, Vec3::Z, Vec3::X][face / 2];
        let b = axis.cross(a);
        let p = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| centre + axis + a * s + b * t);
        let size = 0.4 + 0.3 * face as f32;
        soup.quad(p, [axis; 4], [0.1 * face as f32, 0.3], [if face % 2 == 0 { size } else { -size }, size]);
    }
    soup.primitive()
}

/// A Möbius strip, with opposite normals at its seam.
fn moebius(centre: Vec3) -> Primitive {
    let mut soup = Soup::default();
    let at = |i: u32, side: f32| {
        let around = std::f32::consts::TAU * i as f32 / 24.0;
        let outward = Vec3::new(around.cos(), around.sin(), 0.0);
        let across = outward * (0.5 * around).cos() + Vec3::Z * (0.5 * around).sin();
        let along = Vec3::new(-around.sin(), around.cos(), 0.0);
        (centre + outward + across * side, across.cross(along))
    };
    for i in 0..24 {
        let [a, b, c, d] = [at(i, -0.4), at(i + 1, -0.4), at(i + 1, 0.4), at(i, 0.4)];
        let s = i as f32 * 0.3;
        soup.quad([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1], [s, 0.0], [s + 0.3, 0.8]);
    }
    soup.primitive()
}

/// A sphere with sliver triangles at the poles, in a chart mirrored in the middle. A fin adds edges with three or more triangles.
fn finned_sphere(centre: Vec3) -> Primitive {
    let mut soup = Soup::default();
    let at = |i: u32, j: u32| {
        let (around, down) = (std::f32::consts::TAU * i as f32 / 32.0, std::f32::consts::PI * j as f32 / 12.0);
        Vec3::new(around.cos() * down.sin(), around.sin() * down.sin(), down.cos())
    };
    for (i, j) in (0..32).flat_map(|i| (0..12).map(move |j| (i, j))) {
        let n = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        let s = |i: u32| i.abs_diff(16) as f32 / 10.0;
        soup.quad(n.map(|n| centre + n), n, [s(i), j as f32 * 0.2], [s(i + 1), (j + 1) as f32 * 0.2]);
    }
    for i in 0..32 {
        let (a, b) = (at(i, 6), at(i + 1, 6));
        soup.quad([a, b, b * 1.5, a * 1.5].map(|p| centre + p), [Vec3::Z; 4], [0.0, 0.0], [0.4, 0.7]);
    }
    soup.primitive()
}

fn search(gpu: &TestGpu, stage: Stage, views: u32, time: f64) -> Cracks {
    assert!(stage.objects.last().is_some_and(|ground| !ground.mesh.triangles));
    cracks::search(gpu, stage, Search { views, size: (128, 96), time }).unwrap()
}

fn hard_shapes() -> Model {
    let shapes = [cube(Vec3::ZERO), moebius(Vec3::X * 4.0), finned_sphere(Vec3::X * -4.0)];
    let mut model = model(shapes.into());
    model.materials.iter_mut().for_each(|material| material.relief = Some(rough_relief(Some(0.12))));
    model
}

#[test]
fn hard_shapes_have_no_cracks_unless_their_seams_are_torn() {
    let Some(gpu) = test_gpu() else { return };
    let made = || stage(ModelChoice::new(hard_shapes(), None).unwrap()).unwrap();
    let whole = search(&gpu, made(), 5, 0.0);
    let mut torn = made();
    torn.objects.iter_mut().for_each(|object| object.mesh.welds.clear());
    let torn = search(&gpu, torn, 3, 0.0);
    println!("whole: {whole:?}, torn: {torn:?}");
    assert_eq!(whole.cracks, 0);
    assert!(whole.searched > 15_000 && torn.cracks > 15, "{whole:?} {torn:?}");
}

/// Height scales that differ between the vertices of a seam, and between the sides of a seam in the map.
#[test]
fn varied_heights_have_no_cracks() {
    let Some(gpu) = test_gpu() else { return };
    let mut model = hard_shapes();
    for primitive in &mut model.meshes[0].primitives {
        let scale = |i: usize| 0.2 + ((i * 37) % 11) as f32 / 10.0;
        primitive.height_scales = Some((0..primitive.positions.len()).map(scale).collect());
    }
    let mut made = stage(ModelChoice::new(model, None).unwrap()).unwrap();
    let map = |s: u32, t: u32| 0.3 + 0.7 * ((s * 5 + t * 3) % 8) as f32 / 7.0;
    let texels: Vec<f32> = (0..64).map(|i| map(i % 8, i / 8)).collect();
    let map = FactorMap { width: 8, height: 8, texels, transform: Affine2::from_scale(Vec2::splat(0.37)) };
    let displaced = made.objects.iter_mut().filter(|object| object.mesh.triangles);
    displaced.for_each(|object| object.height_scale_map = Some(map.clone()));
    let whole = search(&gpu, made, 3, 0.0);
    println!("{whole:?}");
    assert!(whole.cracks == 0 && whole.searched > 8_000, "{whole:?}");
}

#[test]
fn materials_meet_without_cracks() {
    let Some(gpu) = test_gpu() else { return };
    // The faces of a cube in two materials, one of them displaced.
    let halves = |displaced: bool| {
        let Primitive { triangles, .. } = cube(Vec3::ZERO);
        let (top, rest) = triangles.split_at(4);
        let part = |triangles: &[[u32; 3]]| Primitive { triangles: triangles.to_vec(), ..cube(Vec3::ZERO) };
        let mut model = model(vec![part(top), part(rest)]);
        model.materials[0].relief = Some(rough_relief(Some(0.15)));
        if displaced {
            model.materials[1].relief = Some(rough_relief(Some(0.1)));
        }
        model
    };
    for displaced in [false, true] {
        let made = || stage(ModelChoice::new(halves(displaced), None).unwrap()).unwrap();
        let whole = search(&gpu, made(), 3, 0.0);
        let mut torn = made();
        torn.objects.iter_mut().for_each(|object| object.mesh.rims.clear());
        let torn = search(&gpu, torn, 4, 0.0);
        println!("displaced beside: {displaced}, whole: {whole:?}, torn: {torn:?}");
        assert!(whole.cracks == 0 && whole.searched > 10_000 && torn.cracks > 10, "{whole:?} {torn:?}");
    }
}

#[test]
fn sample_creatures_have_no_cracks_in_motion() {
    let Some(gpu) = test_gpu() else { return };
    let Some(folder) = shared_data("creatures") else { return };
    let creature = |file: &Path| roughened(Model::load(file, LoadOptions::default()).unwrap(), None);
    let mut all_torn = 0;
    for file in ["fox/Fox.glb", "trex_quaternius/Trex.glb"] {
        let made = || stage(ModelChoice::new(creature(&folder.join(file)), None).unwrap()).unwrap();
        let whole = search(&gpu, made(), 2, 0.3);
        let mut torn = made();
        torn.objects.iter_mut().for_each(|object| object.mesh.welds.clear());
        let torn = search(&gpu, torn, 1, 0.3);
        println!("{file}: {whole:?}, torn: {torn:?}");
        assert!(whole.cracks == 0 && whole.searched > 3_000, "{file}: {whole:?}");
        all_torn += torn.cracks;
    }
    assert!(all_torn > 10, "{all_torn}");
}
