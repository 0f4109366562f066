//! Tests of animated creatures against known facts, and against vertex positions from another program.

use glam::Vec3;
use serde_json::Value;

use crate::samples::load;
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

/// The facts from the notes beside the data, or from the JSON where the notes give none.
struct Facts {
    file: &'static str,
    vertices: usize,
    triangles: usize,
    primitives: usize,
    joints: usize,
    clips: &'static [(&'static str, f32)],
}

const CREATURES: [Facts; 3] = [
    Facts {
        file: "trex_lasquetispice/trex_notextures.glb",
        vertices: 7036,
        triangles: 11_938,
        primitives: 1,
        joints: 72,
        clips: &[("run", 9.27), ("bite", 10.97), ("roar", 9.0), ("attack_tail", 6.0), ("idle", 11.87)],
    },
    Facts {
        file: "trex_quaternius/Trex.glb",
        vertices: 3496,
        triangles: 1820,
        primitives: 5,
        joints: 29,
        clips: &[("Walk", 1.38), ("Run", 0.92), ("Idle", 2.5), ("Jump", 1.46), ("Attack", 1.17), ("Death", 1.58)],
    },
    // The model has no normals, and each triangle already has its own three vertices.
    Facts {
        file: "fox/Fox.glb",
        vertices: 1728,
        triangles: 576,
        primitives: 1,
        joints: 24,
        clips: &[("Survey", 3.42), ("Walk", 0.71), ("Run", 1.16)],
    },
];

#[test]
fn creatures_match_their_source() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("creatures") else { return };
    for facts in CREATURES {
        let model = load(&folder.join(facts.file));
        let primitives = || model.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let vertices: usize = primitives().map(|p| p.positions.len()).sum();
        let triangles: usize = primitives().map(|p| p.triangles.len()).sum();
        println!("{}: {vertices} vertices, {triangles} triangles, {:?}", facts.file, model.remarks);
        assert_eq!((vertices, triangles), (facts.vertices, facts.triangles), "{}", facts.file);
        assert_eq!(primitives().count(), facts.primitives, "{}", facts.file);
        assert_eq!(model.skins.iter().map(|skin| skin.joints.len()).max(), Some(facts.joints), "{}", facts.file);
        for &(clip, seconds) in facts.clips {
            let names: Vec<_> = model.animations.iter().map(|a| (&a.name, a.duration)).collect();
            let found = model.animations.iter().find(|a| a.name.to_lowercase().contains(&clip.to_lowercase()));
            let found = found.unwrap_or_else(|| panic!("{clip} is not among {names:?}"));
            assert!((found.duration - seconds).abs() < 0.01, "{clip}: {names:?}");
        }
        assert_eq!(model.animations.len(), facts.clips.len());
        assert!(model.remarks.is_empty(), "{:?}", model.remarks);
    }
}

/// The script `crates/leadr-models/tests/data/posed_creatures.py` computed the positions in double precision.
#[test]
fn posed_creatures_are_where_another_program_finds_them() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("creatures") else { return };
    let cases: Value = serde_json::from_str(include_str!("../data/posed_creatures.json")).unwrap();
    let mut compared = 0;
    for case in cases.as_array().unwrap() {
        let model = load(&folder.join(case["file"].as_str().unwrap()));
        let clip = case["clip"].as_str().unwrap();
        let animation = model.animations.iter().position(|a| a.name.contains(clip));
        let pose = model.pose(animation, case["seconds"].as_f64().unwrap() as f32);
        let rest = model.pose(None, 0.0);
        let node = model.nodes.iter().position(|node| node.mesh.is_some() && node.skin.is_some()).unwrap();
        for vertex in case["vertices"].as_array().unwrap() {
            let number = |key: &str| vertex[key].as_u64().unwrap() as usize;
            let at =
                |pose| Vec3::from(model.posed_vertices(pose, node, number("primitive")).positions[number("vertex")]);
            let wanted: Vec<f32> =
                vertex["position"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect();
            let wanted = Vec3::from_slice(&wanted);
            let found = at(&pose);
            assert!(found.distance(wanted) < 1e-5 * wanted.length(), "{case}: {found} instead of {wanted}");
            // The rest pose must fail the comparison.
            assert!(at(&rest).distance(wanted) > 1e-3 * wanted.length(), "{vertex} does not move");
            compared += 1;
        }
    }
    assert_eq!(compared, 10);
}
