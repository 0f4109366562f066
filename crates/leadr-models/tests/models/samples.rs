//! Tests of third-party models. Every file loads with the documented content, or is refused for its actual fault.

use std::path::{Path, PathBuf};

use leadr_models::{LoadOptions, Model};
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

/// Returns the models in a folder of the shared data and its subfolders, in sorted order.
pub fn models_under(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(models_under(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
    found.sort();
    found
}

pub fn load(path: &Path) -> Model {
    Model::load(path, LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The remark or error of each unusual file. All other files load without remarks.
const SAID: [(&str, &str); 17] = [
    ("ClearCoatTest.gltf", "unsupported extensions: KHR_materials_clearcoat"),
    ("quad_skin.glb", "3 of 4 vertices follow more than four joints"),
    ("Mesh_PrimitiveMode_00.gltf", "points, which are not drawn"),
    ("Mesh_PrimitiveMode_01.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_02.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_03.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_07.gltf", "points, which are not drawn"),
    ("Mesh_PrimitiveMode_08.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_09.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_10.gltf", "lines, which are not drawn"),
    ("BoxBadNormals.glb", "8 of 24 normals are not of unit length"),
    ("BoxWithInfinites.glb", "accessor 2: element 0 holds -inf"),
    ("Cube.gltf", "buffer view 2: needs bytes 504 to 936, but the buffer has 514"),
    ("MissingBin/BoxTextured.gltf", "\"BoxTextured0.bin\" cannot be found"),
    ("RecursiveNodes.gltf", "node 0: is its own ancestor"),
    ("sceneWrongType.gltf", "the model: `scene` must be a whole number"),
    ("scene.gltf", "cannot be found"),
];

const REFUSED: [&str; 6] = [
    "BoxWithInfinites.glb",
    "Cube.gltf",
    "BoxTextured.gltf",
    "RecursiveNodes.gltf",
    "sceneWrongType.gltf",
    "scene.gltf",
];

#[test]
fn every_sample_loads_or_reports_its_fault() {
    let _unmeasured = unmeasured();
    for folder in ["creatures", "gltf", "bad-input/gltf"] {
        let Some(folder) = shared_data(folder) else { continue };
        let all = models_under(&folder);
        assert!(!all.is_empty(), "no model in {}", folder.display());
        for path in all {
            let text = SAID.iter().find(|(name, _)| path.ends_with(name)).map(|(_, text)| *text);
            let name = path.file_name().unwrap().to_str().unwrap();
            let bad = folder.ends_with("bad-input/gltf") || name == "scene.gltf";
            match Model::load(&path, LoadOptions::default()) {
                Ok(model) => {
                    assert!(!(bad && REFUSED.contains(&name)), "{name} was accepted");
                    let all = model.remarks.join("\n");
                    println!("{name}: {:?}", model.remarks);
                    assert!(text.map_or(all.is_empty(), |text| all.contains(text)), "{name}: {all}");
                }
                Err(error) => {
                    let message = error.to_string();
                    println!("{}", message.rsplit('/').next().unwrap());
                    assert!(bad && REFUSED.contains(&name), "{message}");
                    assert!(message.contains(text.expect("a reason")), "{message}");
                    assert!(message.contains(name) && !message.contains('\n') && message.len() < 400, "{message}");
                }
            }
        }
    }
}

/// By the README's figures, two triangles form a square in every primitive mode.
#[test]
fn every_primitive_mode_makes_the_same_square() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("gltf/glTF-Asset-Generator/Mesh_PrimitiveMode") else { return };
    for number in [4, 5, 6, 11, 12, 13, 14, 15] {
        let model = load(&folder.join(format!("Mesh_PrimitiveMode_{number:02}.gltf")));
        let primitive = &model.meshes[0].primitives[0];
        assert_eq!(primitive.triangles.len(), 2, "{number}");
        let mut area = 0.0;
        for triangle in &primitive.triangles {
            let [a, b, c] = triangle.map(|v| glam::Vec3::from(primitive.positions[v as usize]));
            let normal = (b - a).cross(c - a) / 2.0;
            // All triangles face the viewer.
            assert!(normal.z > 0.0, "{number}: {normal}");
            area += normal.z;
        }
        assert!((area - 1.0).abs() < 1e-6, "{number}: {area}");
    }
}
