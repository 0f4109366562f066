//! A garden snail that crawls in place. The mesh is skinned, 60 mm long, and faces +z.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};
use serde_json::{Value, json};

use crate::gltf::Glb;
use crate::noise::step;
use crate::sweep::{Mesh, Vertex};
use crate::{shell, skin};

/// The duration of the animation in seconds, and the number of keys.
const SECONDS: f32 = 4.0;
const KEYS: usize = 24;

/// A joint with its name, parent and rest position.
struct Joint {
    name: &'static str,
    parent: Option<usize>,
    position: Vec3,
}

/// The joints along the foot from the tail to the neck. The neck carries the head and the stalks, and the shell is attached to the body.
const JOINTS: [Joint; 11] = [
    Joint { name: "body", parent: None, position: Vec3::new(0.0, 0.004, 0.0) },
    Joint { name: "tail", parent: Some(0), position: Vec3::new(0.0, 0.003, -0.026) },
    Joint { name: "hind", parent: Some(0), position: Vec3::new(0.0, 0.004, -0.013) },
    Joint { name: "fore", parent: Some(0), position: Vec3::new(0.0, 0.005, 0.006) },
    Joint { name: "neck", parent: Some(3), position: Vec3::new(0.0, 0.007, 0.017) },
    Joint { name: "head", parent: Some(4), position: Vec3::new(0.0, 0.012, 0.027) },
    Joint { name: "left stalk", parent: Some(5), position: Vec3::new(0.0022, 0.0166, 0.0300) },
    Joint { name: "right stalk", parent: Some(5), position: Vec3::new(-0.0022, 0.0166, 0.0300) },
    Joint { name: "left feeler", parent: Some(5), position: Vec3::new(0.0017, 0.0125, 0.0335) },
    Joint { name: "right feeler", parent: Some(5), position: Vec3::new(-0.0017, 0.0125, 0.0335) },
    Joint { name: "shell", parent: Some(0), position: Vec3::new(0.0, 0.009, -0.004) },
];

/// Returns the centre line of the body: z, the height of the centre, and half the width and height. `t` runs from tail to mouth.
fn body_line(t: f32) -> (f32, f32, Vec2) {
    let z = -0.030 + 0.066 * t;
    let lifted = 0.0085 * step(0.62, 1.0, t);
    let tail = (t / 0.5).min(1.0).powf(0.75);
    let sole = sole(t);
    let nose = (1.0 - ((t - 0.86) / (1.0 - 0.86)).max(0.0).powi(2)).max(0.0).sqrt();
    let waist = 1.0 - 0.22 * step(0.55, 0.78, t);
    let half = Vec2::new(0.0074 * tail * waist, 0.0056 * tail * (1.0 - 0.10 * step(0.6, 0.9, t))) * nose;
    // The sole lies on the ground.
    (z, half.y * (1.0 - FLAT * sole) + lifted, half)
}

/// Fraction of the height of the lower half that a flat sole lacks.
const FLAT: f32 = 0.35;

/// How flat the underside is: 1 on the ground, 0 under the head.
fn sole(t: f32) -> f32 {
    step(0.85, 0.55, t)
}

/// Returns a point of the body's surface. `v` runs around from below. The sole is flat, and flares at its rim.
fn body_position(t: f32, v: f32) -> Vec3 {
    let (z, middle, half) = body_line(t);
    let angle = v * TAU - 0.5 * PI;
    let (sine, cosine) = angle.sin_cos();
    let sole = sole(t);
    let rim = 1.0 + 0.30 * sole * (-((sine + 0.55) / 0.28).powi(2)).exp();
    let y = if sine < 0.0 { sine * (1.0 - FLAT * sole * sine * sine) } else { sine };
    Vec3::new(half.x * cosine * rim, middle + half.y * y, z)
}

/// The largest half-size in [`body_line`]. The texture wraps around this size once.
const WIDEST: f32 = 0.0093;

/// The number of rings of the body. The rings are denser near the mouth.
const RINGS: usize = 56;

fn ring(u: f32) -> f32 {
    1.0 - (1.0 - u).powf(1.6)
}

/// The texture coordinates of the skin. The coordinates follow the arc length along the back, and the width of the body to both sides, so
/// that spots have a uniform size and meet under the sole.
struct BodyTexture {
    /// The arc length of the back at even steps from tail to mouth, relative to the whole length.
    lengths: Vec<f32>,
}

impl BodyTexture {
    fn new() -> Self {
        let steps = 400;
        let back = |i: usize| body_position(ring(i as f32 / steps as f32), 0.5);
        let mut lengths = vec![0.0];
        for i in 0..steps {
            lengths.push(lengths[i] + back(i).distance(back(i + 1)));
        }
        let whole = lengths[steps];
        lengths.iter_mut().for_each(|length| *length /= whole);
        Self { lengths }
    }

    fn at(&self, u: f32, v: f32) -> Vec2 {
        let position = u.clamp(0.0, 1.0) * (self.lengths.len() - 1) as f32;
        let i = (position as usize).min(self.lengths.len() - 2);
        let length = self.lengths[i] + (self.lengths[i + 1] - self.lengths[i]) * (position - i as f32);
        let (_, _, half) = body_line(ring(u));
        Vec2::new(1.6 * length, 0.5 + (0.5 - v) * half.length() / WIDEST)
    }
}

/// Returns the joints of a point of the body: the nearest joint in front and the nearest joint behind.
fn body_joints(_: f32, p: Vec3) -> [(u16, f32); 4] {
    const LINE: [(u16, f32); 5] = [(1, -0.026), (2, -0.013), (3, 0.006), (4, 0.017), (5, 0.027)];
    let next = LINE.iter().position(|(_, z)| p.z < *z).unwrap_or(LINE.len());
    if next == 0 || next == LINE.len() {
        return [(LINE[next.clamp(1, LINE.len()) - 1].0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
    }
    let [(a, from), (b, to)] = [LINE[next - 1], LINE[next]];
    let share = step(from, to, p.z);
    [(a, 1.0 - share), (b, share), (0, 0.0), (0, 0.0)]
}

/// Adds a stalk from a joint to the offset `tip`, with a knob at its end.
fn stalk(mesh: &mut Mesh, joint: u16, tip: Vec3, radius: f32, knob: f32) {
    let root = JOINTS[joint as usize].position - tip * 0.12;
    let along = tip * 1.12;
    let side = along.cross(Vec3::X).normalize();
    let up = side.cross(along).normalize();
    let width = move |u: f32| {
        let thin = radius * (1.35 - 0.6 * u.min(0.8) / 0.8);
        let end = (1.0 - ((u - 0.9) / 0.1).clamp(-1.0, 1.0).powi(2)).max(0.0).sqrt() * knob;
        // The root is closed inside the head.
        let root = (u / 0.02).min(1.0).sqrt();
        if u > 0.9 { end } else { root * thin.max(end) }
    };
    let position = move |u: f32, v: f32| {
        let (s, c) = (v * TAU).sin_cos();
        root + along * u + (side * s + up * c) * width(u)
    };
    let weights = move |u: f32, _: Vec3| {
        let share = step(0.0, 0.3, u);
        [(5, 1.0 - share), (joint, share), (0, 0.0), (0, 0.0)]
    };
    let uv = move |u: f32, v: f32| Vec2::new(0.8 + 0.2 * u, 0.12 + 0.25 * (0.5 - v) * width(u) / radius);
    mesh.tube([20, 12], position, uv, weights);
}

/// Adds an eye, which is a dark bead on the tip of a stalk.
fn eye(mesh: &mut Mesh, joint: u16, tip: Vec3) {
    let centre = JOINTS[joint as usize].position + tip * 0.99 + Vec3::new(0.0, 0.0001, 0.0002);
    let position = move |u: f32, v: f32| {
        let ((s, c), (sv, cv)) = ((u * PI).sin_cos(), (v * TAU).sin_cos());
        centre + 0.0008 * Vec3::new(s * cv, c, s * sv)
    };
    mesh.tube([10, 14], position, Vec2::new, move |_, _| [(joint, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]);
}

/// Returns the meshes of skin, shell and eyes.
fn meshes() -> [Mesh; 3] {
    let [mut skin, mut shell, mut eyes] = [Mesh::default(), Mesh::default(), Mesh::default()];
    let texture = BodyTexture::new();
    skin.tube([RINGS, 28], |u, v| body_position(ring(u), v), |u, v| texture.at(u, v), body_joints);
    let upper = |side: f32| Vec3::new(0.0026 * side, 0.0086, 0.0040);
    let lower = |side: f32| Vec3::new(0.0016 * side, -0.0008, 0.0038);
    for (joint, side) in [(6, 1.0), (7, -1.0)] {
        stalk(&mut skin, joint, upper(side), 0.00078, 0.00092);
        stalk(&mut skin, joint + 2, lower(side), 0.00055, 0.00060);
        eye(&mut eyes, joint, upper(side));
    }
    shell.tube(
        [120, 20],
        |u, v| shell::position(u * shell::INNER, v),
        |u, v| shell::uv(u * shell::INNER, v),
        |_, _| [(10, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
    );
    // A lid of the body's colour closes the mouth inside the lip.
    let lid = |u: f32, v: f32| {
        let centre = (0..8).map(|k| shell::position(shell::INNER, k as f32 / 8.0)).sum::<Vec3>() / 8.0;
        centre.lerp(shell::position(shell::INNER, v), u)
    };
    skin.tube(
        [3, 20],
        |u, v| lid(1.0 - u, v),
        |u, v| Vec2::new(0.4, 0.5) + 0.12 * (1.0 - u) * Vec2::from_angle(v * TAU),
        |_, _| [(10, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
    );
    [skin, shell, eyes]
}

/// A connected part of the snail, with coincident vertices welded.
#[cfg(test)]
#[derive(Debug)]
pub struct Part {
    /// Number of edges that do not join two triangles in opposite directions.
    pub open_edges: usize,
    /// Enclosed volume, cubic metres; negative if the triangles face inward.
    pub volume: f32,
    /// Lowest point, metres.
    pub lowest: f32,
}

/// The connected parts of all meshes at rest.
#[cfg(test)]
pub fn parts() -> Vec<Part> {
    use std::collections::HashMap;
    let mut points: HashMap<[i64; 3], usize> = HashMap::new();
    let mut positions = Vec::new();
    let mut triangles: Vec<[usize; 3]> = Vec::new();
    for mesh in meshes() {
        let welded: Vec<usize> = mesh
            .vertices
            .iter()
            .map(|vertex| {
                let key = vertex.position.to_array().map(|x| (f64::from(x) * 1e7).round() as i64);
                *points.entry(key).or_insert_with(|| {
                    positions.push(vertex.position);
                    positions.len() - 1
                })
            })
            .collect();
        let corners = mesh.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| welded[usize::from(t[k])]));
        triangles.extend(corners.filter(|[a, b, c]| a != b && b != c && c != a));
    }
    let mut root: Vec<usize> = (0..positions.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for &[a, b, c] in &triangles {
        for (p, q) in [(a, b), (b, c)] {
            let (p, q) = (find(&mut root, p), find(&mut root, q));
            root[p] = q;
        }
    }
    let mut edges: HashMap<[usize; 2], i32> = HashMap::new();
    let mut parts: HashMap<usize, Part> = HashMap::new();
    for &[a, b, c] in &triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_default() += 1;
        }
        let part = find(&mut root, a);
        let part = parts.entry(part).or_insert(Part { open_edges: 0, volume: 0.0, lowest: f32::MAX });
        let p = [a, b, c].map(|i| positions[i]);
        part.volume += p[0].dot(p[1].cross(p[2])) / 6.0;
        part.lowest = p.iter().fold(part.lowest, |lowest, p| lowest.min(p.y));
    }
    for (&[a, b], &count) in &edges {
        if count != edges.get(&[b, a]).copied().unwrap_or(0) {
            parts.get_mut(&find(&mut root, a)).expect("each edge has a part").open_edges += 1;
        }
    }
    parts.into_values().collect()
}

/// Position and rotation of a joint at an animation phase, 0 to 1.
fn pose(joint: usize, phase: f32) -> (Vec3, Quat) {
    let position = JOINTS[joint].position - JOINTS[joint].parent.map_or(Vec3::ZERO, |parent| JOINTS[parent].position);
    let wave = |delay: f32| ((phase - delay) * TAU).sin();
    let twice = |delay: f32| ((2.0 * phase - delay) * TAU).sin();
    let rotation = |x: f32, y: f32, z: f32| Quat::from_euler(glam::EulerRot::YXZ, y, x, z);
    match JOINTS[joint].name {
        // A stretching wave runs from tail to head.
        "tail" => (position + Vec3::Z * (0.0024 * wave(0.0)), rotation(0.0, 0.10 * wave(0.25), 0.0)),
        "hind" => (position + Vec3::Z * (0.0016 * wave(0.15)), rotation(0.0, 0.05 * wave(0.4), 0.0)),
        "fore" => (position + Vec3::Z * (0.0016 * wave(0.35)), rotation(0.0, 0.06 * wave(0.6), 0.0)),
        "neck" => {
            (position + Vec3::Z * (0.0018 * wave(0.45)), rotation(-0.07 + 0.09 * wave(0.5), 0.14 * wave(0.7), 0.0))
        }
        "head" => (position, rotation(0.10 * wave(0.62), 0.22 * wave(0.8), 0.05 * wave(0.3))),
        "left stalk" => (position, rotation(0.24 * twice(0.1), 0.0, 0.20 * wave(0.2) - 0.05)),
        "right stalk" => (position, rotation(0.24 * twice(0.55), 0.0, 0.20 * wave(0.55) + 0.05)),
        "left feeler" => (position, rotation(0.25 * twice(0.3), 0.30 * twice(0.8), 0.0)),
        "right feeler" => (position, rotation(0.25 * twice(0.7), 0.30 * twice(0.2), 0.0)),
        "shell" => (
            position + Vec3::new(0.0, 0.0004 + 0.0004 * wave(0.2), 0.0010 * wave(0.3)),
            rotation(0.05 * wave(0.45), 0.03 * wave(0.1), 0.06 * wave(0.7)),
        ),
        _ => (position, Quat::IDENTITY),
    }
}

/// Writes a mesh and returns its primitive.
fn primitive(glb: &mut Glb, mesh: &Mesh, material: usize, textured: bool) -> Value {
    const ARRAY: u32 = 34_962;
    const INDICES: u32 = 34_963;
    let column =
        |of: fn(&Vertex) -> Vec3| -> Vec<[f32; 3]> { mesh.vertices.iter().map(|v| of(v).to_array()).collect() };
    let tangents: Vec<[f32; 4]> = mesh.vertices.iter().map(|v| v.tangent).collect();
    let uvs: Vec<[f32; 2]> = mesh.vertices.iter().map(|v| v.uv.to_array()).collect();
    let joints: Vec<[u16; 4]> =
        mesh.vertices.iter().map(|v| v.joints.map(|(joint, share)| if share > 0.0 { joint } else { 0 })).collect();
    let weights: Vec<[f32; 4]> = mesh.vertices.iter().map(|v| v.joints.map(|(_, share)| share)).collect();
    let indices: Vec<[u16; 1]> = mesh.indices.iter().map(|&index| [index]).collect();
    let mut attributes = json!({
        "POSITION": glb.floats(&column(|v| v.position), Some(ARRAY), true),
        "NORMAL": glb.floats(&column(|v| v.normal), Some(ARRAY), false),
        "JOINTS_0": glb.shorts(&joints, ARRAY),
        "WEIGHTS_0": glb.floats(&weights, Some(ARRAY), false),
    });
    if textured {
        attributes["TANGENT"] = json!(glb.floats(&tangents, Some(ARRAY), false));
        attributes["TEXCOORD_0"] = json!(glb.floats(&uvs, Some(ARRAY), false));
    }
    json!({ "attributes": attributes, "indices": glb.shorts(&indices, INDICES), "material": material })
}

/// Returns the GLB file.
pub fn file() -> Vec<u8> {
    let mut glb = Glb::default();
    let [skin, shell, eyes] = meshes();
    let primitives = [
        primitive(&mut glb, &skin, 0, true),
        primitive(&mut glb, &shell, 1, true),
        primitive(&mut glb, &eyes, 2, false),
    ];
    let inverse: Vec<[f32; 16]> =
        JOINTS.iter().map(|joint| glam::Mat4::from_translation(-joint.position).to_cols_array()).collect();
    let inverse = glb.floats(&inverse, None, false);
    let times: Vec<[f32; 1]> = (0..=KEYS).map(|k| [SECONDS * k as f32 / KEYS as f32]).collect();
    let input = glb.floats(&times, None, true);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for joint in 1..JOINTS.len() {
        let keys: Vec<(Vec3, Quat)> = (0..=KEYS).map(|k| pose(joint, (k % KEYS) as f32 / KEYS as f32)).collect();
        let moved: Vec<[f32; 3]> = keys.iter().map(|(position, _)| position.to_array()).collect();
        let rotations: Vec<[f32; 4]> = keys.iter().map(|(_, rotation)| rotation.to_array()).collect();
        let outputs =
            [("translation", glb.floats(&moved, None, false)), ("rotation", glb.floats(&rotations, None, false))];
        for (path, output) in outputs {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": joint, "path": path } }));
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
    }
    let pictures = [skin::pictures(384, skin::surface), skin::pictures(384, shell::surface)];
    let images: Vec<Value> = pictures
        .iter()
        .flatten()
        .map(|bytes| json!({ "bufferView": glb.view(bytes, None), "mimeType": "image/png" }))
        .collect();
    let textures: Vec<Value> = (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect();
    let material = |name: &str, first: usize| {
        json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": first },
                "metallicRoughnessTexture": { "index": first + 2 },
                "metallicFactor": 0.0,
            },
            "normalTexture": { "index": first + 1 },
        })
    };
    let nodes: Vec<Value> = (0..JOINTS.len())
        .map(|joint| {
            let (position, rotation) = pose(joint, 0.0);
            let children: Vec<usize> = (0..JOINTS.len()).filter(|&child| JOINTS[child].parent == Some(joint)).collect();
            let mut node =
                json!({ "name": JOINTS[joint].name, "translation": position.to_array(), "rotation": rotation.to_array() });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        })
        .chain([json!({ "name": "snail", "mesh": 0, "skin": 0 })])
        .collect();
    glb.file(json!({
        "asset": { "version": "2.0", "generator": "leadr-vk 16_make_assets", "copyright": "leadr-vk, MIT or Apache 2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, JOINTS.len()] }],
        "nodes": nodes,
        "meshes": [{ "name": "snail", "primitives": primitives }],
        "skins": [{ "joints": (0..JOINTS.len()).collect::<Vec<_>>(), "skeleton": 0, "inverseBindMatrices": inverse }],
        "animations": [{ "name": "Crawl", "samplers": samplers, "channels": channels }],
        "materials": [
            material("skin", 0),
            material("shell", 3),
            { "name": "eyes", "pbrMetallicRoughness": { "baseColorFactor": [0.012, 0.010, 0.009, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.12 } },
        ],
        "textures": textures,
        "images": images,
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
    }))
}
