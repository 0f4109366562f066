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
const SAID: [(&str, &str); 16] = [
    ("quad_skin.glb", "3 of 4 vertices follow more than four joints"),
    ("Mesh_PrimitiveMode_00.gltf", "points, which are not drawn"),
    ("Mesh_PrimitiveMode_01.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_02.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_03.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_07.gltf", "points, which are not drawn"),
    ("Mesh_PrimitiveMode_08.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_09.gltf", "lines, which are not drawn"),
    ("Mesh_PrimitiveMode_10.gltf", "lines, which are not drawn"),
    ("BoxBadNormals.glb", "4 of 24 normals are not of unit length"),
    ("BoxWithInfinites.glb", "`POSITION` of vertex 0 is -inf"),
    ("Cube.gltf", "buffer view 2: needs bytes 504 to 936, but the buffer has 514"),
    ("MissingBin/BoxTextured.gltf", "\"BoxTextured0.bin\" cannot be found"),
    ("RecursiveNodes.gltf", "node 0: is its own ancestor"),
    ("sceneWrongType.gltf", "\"BoxTextured0.bin\" cannot be found"),
    ("scene.gltf", "cannot be found"),
];

const REFUSED: [&str; 5] =
    ["BoxWithInfinites.glb", "BoxTextured.gltf", "RecursiveNodes.gltf", "sceneWrongType.gltf", "scene.gltf"];

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

/// The start of the remarks on each reported file. The others have none.
const REPORTED: [(&str, &str); 24] = [
    ("anim_duplicate_time.gltf", "time 2 is 1 after 1, but times must increase; the keys are sorted"),
    ("anim_negative_time.gltf", "its first time is -0.125, but must be at least 0; the animation starts at 0"),
    ("anim_on_matrix_node.gltf", "animates node 0, which has a matrix; the matrix is split into its parts"),
    ("anim_one_key_cubic.gltf", "is a cubic spline with one key; it needs two; its value is constant"),
    ("bom.gltf", "its JSON starts with a byte order mark; the mark is ignored"),
    ("color_u8_not_normalized.gltf", "is VEC4 of bytes; it is read as normalised numbers"),
    ("emissive_above_one.gltf", "`emissiveFactor` is 4, but must be at most 1; it is read as the strength"),
    ("empty_mesh.gltf", "mesh 1: has no primitives; the mesh is left out"),
    ("gltf1.gltf", "it is glTF 1.0; export it as glTF 2.0"),
    ("jpeg_exif6.gltf", "its orientation tag (6) is not applied"),
    ("jpeg_no_eoi.gltf", "its end marker is missing, but all its rows are complete"),
    ("nan_normal.gltf", "1 of 25 normals have no direction; they are replaced by those of the adjacent triangles"),
    ("nan_tangent.gltf", "1 of 25 tangents are not of unit length; they are scaled or replaced"),
    ("nan_texcoord.gltf", "`TEXCOORD_0` of vertex 0 is NaN, but must be within ±1e12; such values are read as 0"),
    ("occlusion_strength_above_one.gltf", "`strength` must be a number from 0 to 1; the nearest valid number is used"),
    ("roughness_above_one.gltf", "`roughnessFactor` must be a number from 0 to 1; the nearest valid number is used"),
    ("scene_lists_child.gltf", "lists node 1, which is not a root but a child of node 0; the node is shown"),
    ("skin_negative_weight.gltf", "5 of 25 vertices have a weight that is negative or not a number"),
    ("skin_zero_weights.gltf", "5 of 25 vertices have only zero weights"),
    ("texcoord_vec3.gltf", "accessor 4 is VEC3 of floats; its first numbers are read"),
    ("uri_backslash.gltf", "has a backslash in its name"),
    ("uri_parent_folder.gltf", "lies outside the model's folder; only files inside it may be read"),
    ("uri_raw_percent.gltf", "\"textures/wood 100%.png\" has a name that is not percent-encoded"),
    ("weights_u8_not_normalized.gltf", "accessor 11 is VEC4 of bytes; it is read as normalised numbers"),
];

/// Files that people have reported load with one remark each.
#[test]
fn reported_files_are_repaired() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("reports") else { return };
    let mut wrong = Vec::new();
    for path in models_under(&folder) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let wanted = REPORTED.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
        let said = match Model::load(&path, LoadOptions::default()) {
            Ok(model) => model.remarks,
            Err(error) => vec![error.fault.to_string()],
        };
        println!("{name}: {said:?}");
        let right = match wanted {
            Some(wanted) => said.len() == 1 && said[0].contains(wanted),
            None => said.is_empty(),
        };
        if !right {
            wrong.push(format!("{name}: {said:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
