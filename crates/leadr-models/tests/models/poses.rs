//! Tests of posed models against closed forms, and against positions from another program.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_8};

use glam::{Mat4, Quat, Vec3};
use leadr_models::{Curve, Interpolation, LoadOptions, Model, PosedVertices};
use serde_json::json;

use crate::build::{Builder, U8, everything, triangle};
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

fn assert_near(found: [f32; 3], wanted: [f32; 3], what: &str) {
    let distance = Vec3::from(found).distance(Vec3::from(wanted));
    assert!(distance < 1e-5, "{what}: {found:?} instead of {wanted:?}");
}

#[test]
fn curves_step_run_straight_and_bend() {
    let curve = |interpolation, values: &[f32]| Curve {
        interpolation,
        times: vec![1.0, 2.0, 4.0],
        width: 1,
        values: values.to_vec(),
    };
    let at = |curve: &Curve, t: f32| curve.sample(t, false)[0];
    let step = curve(Interpolation::Step, &[5.0, 6.0, 7.0]);
    assert_eq!([0.0, 1.0, 1.999, 2.0, 3.9, 4.0, 9.0].map(|t| at(&step, t)), [5.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0]);
    let line = curve(Interpolation::Linear, &[5.0, 6.0, 10.0]);
    assert_eq!([0.0, 1.5, 2.0, 2.5, 3.0, 5.0].map(|t| at(&line, t)), [5.0, 5.5, 6.0, 7.0, 8.0, 10.0]);
    // A Hermite spline reproduces a cubic polynomial from its values and slopes.
    let cubic = |t: f32| t * t * t - 3.0 * t * t + 0.5 * t + 2.0;
    let slope = |t: f32| 3.0 * t * t - 6.0 * t + 0.5;
    // The outermost tangents must have no effect.
    let keys: Vec<f32> = [1.0, 2.0, 4.0f32].iter().flat_map(|&t| [slope(t), cubic(t), slope(t)]).collect();
    let mut keys = keys;
    (keys[0], keys[8]) = (1e6, -1e6);
    let spline = curve(Interpolation::Cubic, &keys);
    for i in 0..=30 {
        let t = 1.0 + 0.1 * i as f32;
        assert!((at(&spline, t) - cubic(t)).abs() < 1e-4, "{t}: {} {}", at(&spline, t), cubic(t));
    }
    assert_eq!((at(&spline, 0.0), at(&spline, 9.0)), (cubic(1.0), cubic(4.0)));
}

#[test]
fn rotations_go_the_short_way_at_constant_speed() {
    let key = |angle: f32, sign: f32| (Quat::from_rotation_y(angle) * sign).to_array();
    for sign in [1.0, -1.0] {
        // Two quaternions with opposite signs are equal rotations. The sign must not select the longer arc.
        let values = [key(0.2, 1.0), key(1.4, sign)].concat();
        let curve = Curve { interpolation: Interpolation::Linear, times: vec![0.0, 2.0], width: 4, values };
        for part in [0.0, 0.25, 0.5, 0.9, 1.0] {
            let found = Quat::from_slice(&curve.sample(2.0 * part, true));
            let wanted = Quat::from_rotation_y(0.2 + 1.2 * part);
            assert!(found.dot(wanted).abs() > 1.0 - 1e-6, "{sign} {part}: {found}");
        }
    }
    // Splines of rotations are normalised.
    let zero = [0.0; 4];
    let values = [zero, key(0.0, 1.0), zero, zero, key(2.0, 1.0), zero].concat();
    let curve = Curve { interpolation: Interpolation::Cubic, times: vec![0.0, 1.0], width: 4, values };
    let middle = Quat::from_slice(&curve.sample(0.5, true));
    assert!(middle.is_normalized() && middle.dot(Quat::from_rotation_y(1.0)) > 1.0 - 1e-6);
}

#[test]
fn pose_is_the_product_of_ancestor_transforms() {
    let _unmeasured = unmeasured();
    let model = everything().model();
    let rest = model.pose(None, 0.0);
    let root = Mat4::from_translation(Vec3::Z);
    assert_eq!(rest.world_from_node[2], root * Mat4::from_scale(Vec3::splat(2.0)));
    assert_eq!(rest.weights[0], [0.5]);
    // At 1.5 s the stepped translation has the second key's value. Node 2 is half-way between a quarter and half a turn
    // about z.
    let pose = model.pose(Some(0), 1.5);
    assert_eq!(pose.world_from_node[1].w_axis.truncate(), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(pose.world_from_bind[0], [pose.world_from_node[1], pose.world_from_node[2]]);
    let start = Quat::from_xyzw(0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2);
    let half_way = start * Quat::from_rotation_z(4.0 * FRAC_PI_8 / 2.0);
    let wanted = Mat4::from_scale_rotation_translation(Vec3::new(1.0, 2.0, 3.0), half_way, Vec3::new(1.0, 2.0, 3.0));
    assert!(pose.world_from_node[2].abs_diff_eq(wanted, 1e-5), "{} {wanted}", pose.world_from_node[2]);
    // The spline goes from 0 (slope 1) to 1 (slope 0), then to 0. Half-way, the Hermite formula gives 5/8.
    assert!((model.pose(Some(0), 0.5).weights[0][0] - 0.625).abs() < 1e-6);
}

#[test]
fn skinned_vertices_follow_their_joints_alone() {
    let _unmeasured = unmeasured();
    let model = everything().model();
    let posed = model.posed_vertices(&model.pose(None, 0.0), 0, 0);
    // Joint 0 lifts by 1, and joint 1 also doubles. The node's transform has no effect. The morph target applies first and
    // lifts by half its weight.
    assert_near(posed.positions[0], [0.0, 0.0, 1.0], "joint 0");
    assert_near(posed.positions[3], [0.0, 2.0, 2.0 * 2.0 + 1.0], "joint 1, with half of a lift of 4");
    let mixed = 0.25 + 0.75 * 2.0;
    assert_near(posed.positions[2], [mixed, mixed, mixed + 1.0], "a quarter of joint 0");
    assert_near(posed.normals[2], [0.0, 0.0, 1.0], "normal");
    assert_eq!(posed.tangents[2], [1.0, 0.0, 0.0, -1.0]);
    assert!(!posed.mirrored);
}

#[test]
fn normals_match_every_carrier_surface() {
    let _unmeasured = unmeasured();
    for flat in [false, true] {
        for scale in [[1.0, 1.0, 1.0], [3.0, 0.5, 1.0], [-1.0, 1.0, 1.0], [1e-15, 2e-15, 1e-15], [-2e8, -1e8, -3e8]] {
            let mut made = triangle();
            let positions = made.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0, 1.0, 0.25]);
            made.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
            if !flat {
                let normal = Vec3::new(-0.5, -0.25, 1.0).normalize().to_array();
                let normals = made.floats("VEC3", &normal.repeat(3));
                made.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
            }
            made.json["nodes"][0]["scale"] = json!(scale);
            made.json["nodes"][0]["rotation"] = json!([0.1, 0.2, 0.3, 0.9]);
            let model = made.model();
            let posed = model.posed_vertices(&model.pose(None, 0.0), 0, 0);
            let [a, b, c] = [0, 1, 2].map(|v| Vec3::from(posed.positions[v]).as_dvec3());
            let mut plane = (b - a).normalize().cross((c - a).normalize()).normalize().as_vec3();
            assert_eq!(posed.mirrored, scale.iter().product::<f32>().is_sign_negative(), "{scale:?}");
            if posed.mirrored {
                plane = -plane;
            }
            for normal in posed.normals {
                assert!(Vec3::from(normal).distance(plane) < 1e-4, "flat {flat}, {scale:?}: {normal:?}, {plane}");
            }
        }
    }
}

#[test]
fn morph_targets_move_normals_and_tangents() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let normals = made.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = made.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let lift = made.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let lean = made.floats("VEC3", &[2.0, 0.0, 0.0].repeat(3));
    let turn = made.floats("VEC3", &[0.0, 2.0, 0.0].repeat(3));
    let primitive = &mut made.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["attributes"]["TANGENT"] = json!(tangents);
    primitive["targets"] = json!([{ "POSITION": lift }, { "NORMAL": lean, "TANGENT": turn }]);
    made.json["nodes"][0]["weights"] = json!([0.25, 0.5]);
    let model = made.model();
    let posed = model.posed_vertices(&model.pose(None, 0.0), 0, 0);
    assert_near(posed.positions[1], [1.0, 0.0, 0.5], "position");
    assert_near(posed.normals[1], [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2], "normal");
    let [x, y, z, sign] = posed.tangents[1];
    assert_near([x, y, z], [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0], "tangent");
    assert_eq!(sign, -1.0);
}

/// If a vertex has more than four joints, the strongest are kept, and the vertex stays inside their hull.
#[test]
fn eight_joints_become_the_strongest_four() {
    let _unmeasured = unmeasured();
    let mut made = Builder::new();
    let positions = made.floats("VEC3", &[0.0; 9]);
    let joints = [0u8, 1, 2, 3].repeat(3);
    let more = [4u8, 5, 6, 7].repeat(3);
    let sets = [made.accessor("VEC4", U8, 3, &joints), made.accessor("VEC4", U8, 3, &more)];
    let weights = [
        made.floats("VEC4", &[0.3, 0.01, 0.2, 0.02].repeat(3)),
        made.floats("VEC4", &[0.25, 0.02, 0.15, 0.05].repeat(3)),
    ];
    let attributes = json!({ "POSITION": positions, "JOINTS_0": sets[0], "WEIGHTS_0": weights[0], "JOINTS_1": sets[1], "WEIGHTS_1": weights[1] });
    made.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    made.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    for joint in 0..8 {
        made.push("nodes", json!({ "translation": [joint as f32, 0.0, 0.0] }));
    }
    made.push("skins", json!({ "joints": [1, 2, 3, 4, 5, 6, 7, 8] }));
    let model = made.model();
    let posed = model.posed_vertices(&model.pose(None, 0.0), 0, 0);
    let wanted = (0.3 * 0.0 + 0.25 * 4.0 + 0.2 * 2.0 + 0.15 * 6.0) / 0.9;
    assert_near(posed.positions[0], [wanted, 0.0, 0.0], "mean of the joints");
    assert!(model.remarks[0].contains("3 of 3 vertices follow more than four joints"), "{:?}", model.remarks);
}

fn posed(file: &str, animation: usize, seconds: f32) -> Option<PosedVertices> {
    let folder = shared_data("gltf")?;
    let model = Model::load(folder.join(file), LoadOptions::default()).unwrap();
    let pose = model.pose(Some(animation), seconds);
    let node = model.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    Some(model.posed_vertices(&pose, node, 0))
}

/// The model is the glTF tutorial's bending strip of ten vertices in rows of two. The upper rows follow the second joint.
#[test]
fn simple_skin_bends_as_in_its_tutorial() {
    let _unmeasured = unmeasured();
    // The keys are half a second apart: 0, 45°, 90°, 90°, 45°, 0, 0, then the same to the other side. The joint is at (0, 1,
    // 0), and is bound at (0.5, 1, 0).
    for (seconds, degrees) in
        [(0.0, 0.0f32), (0.25, 22.5), (0.5, 45.0), (1.0, 90.0), (1.25, 90.0), (3.5, -45.0), (4.25, -90.0), (9.0, 0.0)]
    {
        let Some(posed) = posed("SimpleSkin/simple_skin.gltf", 0, seconds) else { return };
        let corners: Vec<Vec3> = posed.positions.into_iter().map(Vec3::from).collect();
        let there = |position: Vec3| corners.iter().any(|corner| corner.distance(position) < 2e-3);
        let turn = Quat::from_rotation_z(degrees.to_radians());
        let joint = Vec3::Y;
        for (x, y, share) in
            [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.5), (1.0, 1.0, 0.5), (0.0, 2.0, 1.0), (1.0, 2.0, 1.0)]
        {
            let bound = Vec3::new(x - 0.5, y - 1.0, 0.0);
            let wanted = joint + bound.lerp(turn * bound, share);
            assert!(there(wanted), "{seconds} s: {wanted} is not among {corners:?}");
        }
    }
}

/// In the tutorial's triangle, two targets move the tip left and right. Both targets together move the tip straight up.
#[test]
fn the_simple_morph_moves_its_tip() {
    let _unmeasured = unmeasured();
    let tip = |seconds| posed("SimpleMorph/glTF/SimpleMorph.gltf", 0, seconds).map(|posed| posed.positions[2]);
    // The weights at 0, 1, 2, 3 and 4 s are: none, the second, both, the first, none.
    let wanted = [
        (0.0, [0.0, 0.0]),
        (1.0, [0.0, 1.0]),
        (1.5, [0.5, 1.0]),
        (2.0, [1.0, 1.0]),
        (3.0, [1.0, 0.0]),
        (4.0, [0.0, 0.0]),
    ];
    for (seconds, [left, right]) in wanted {
        let Some(tip) = tip(seconds) else { return };
        assert_near(tip, [0.5 - left + right, 0.5 + left + right, 0.0], &format!("{seconds} s"));
    }
}

/// By the README, the two targets make the cube very thin, or a ramp. The test computes volumes by the divergence theorem,
/// so triangles must face outwards.
#[test]
fn the_morphing_cube_becomes_thin_and_a_ramp() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("gltf") else { return };
    let model =
        Model::load(folder.join("AnimatedMorphCube/glTF/AnimatedMorphCube.gltf"), LoadOptions::default()).unwrap();
    let primitive = &model.meshes[0].primitives[0];
    let volume = |seconds: f32| {
        let posed = model.posed_vertices(&model.pose(Some(0), seconds), 0, 0);
        let corner = |v: u32| Vec3::from(posed.positions[v as usize]);
        let part = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
        primitive.triangles.iter().map(part).sum::<f32>()
    };
    // The sides of 0.02 are scaled by 100. The thin shape keeps 0.00107 of one side, and the low edge of the ramp keeps
    // 0.00011.
    for (seconds, wanted) in [(0.0, 8.0), (1.6, 0.427), (3.4, 4.022), (4.2, 8.0)] {
        let found = volume(seconds);
        assert!((found / wanted - 1.0).abs() < 0.005, "{seconds} s: {found} instead of {wanted}");
    }
}
