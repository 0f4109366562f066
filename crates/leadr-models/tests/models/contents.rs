//! Tests of the contents of models that are built in code, part by part.

use glam::{Affine2, Mat4, Vec2, Vec3};
use leadr_maps::material::{Encoding, Opacity, TextureWrap};
use leadr_models::{Interpolation, LightKind, Model, Projection, Property, Transform};
use serde_json::json;

use crate::build::{Builder, F32, I8, I16, U8, U16, everything, triangle};
use crate::hostile::with_attribute;
use leadr_testing::memory::unmeasured;

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}

#[test]
fn a_model_with_everything() {
    let _unmeasured = unmeasured();
    let model = everything().model();
    assert!(model.remarks.is_empty(), "{:?}", model.remarks);
    assert_eq!((model.name.as_str(), model.default_scene), ("made", Some(0)));
    assert_eq!(model.scenes[0].roots, [0, 1]);
    assert_eq!(model.nodes[2].parent, Some(1));
    assert_eq!(model.nodes[1].children, [2, 3]);
    let Transform::Matrix(matrix) = model.nodes[3].transform else { panic!("a matrix") };
    assert_eq!(matrix.w_axis.truncate(), Vec3::new(5.0, 6.0, 7.0));
    assert_eq!(matrix.transform_vector3(Vec3::X), -Vec3::Z);
    assert_eq!((model.nodes[3].camera, model.nodes[3].light), (Some(0), Some(1)));
    assert_eq!((model.nodes[0].skin, &model.nodes[0].weights[..]), (Some(0), &[0.5][..]));

    let primitive = &model.meshes[0].primitives[0];
    assert_eq!(primitive.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(primitive.positions[2], [1.0, 1.0, 0.0]);
    assert!(!primitive.flat && primitive.normals == [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(primitive.tangents.as_ref().unwrap()[3], [1.0, 0.0, 0.0, -1.0]);
    assert_eq!(primitive.texcoords.len(), 2);
    assert_eq!(primitive.texcoords[0], primitive.texcoords[1]);
    let colors = primitive.colors.as_ref().unwrap();
    assert!(colors[0][3] == 1.0 && close(colors[0][2], 0.2) && close(colors[3][0], 0.4));
    let influences = primitive.influences.as_ref().unwrap();
    assert_eq!((influences[2].joints, influences[2].weights), ([1, 0, 0, 0], [0.75, 0.25, 0.0, 0.0]));
    let target = &primitive.targets[0];
    assert_eq!((&model.meshes[0].target_names[..], model.meshes[0].target_count), (&["lift".to_owned()][..], 1));
    assert_eq!((target.positions.len(), target.normals.len()), (4, 0));
    assert_eq!([1, 2, 3].map(|v| target.positions[v][2]), [0.0, 2.0, 4.0]);

    assert_eq!(model.cameras[0].projection, Projection::Perspective { vertical_angle: 0.7, aspect: Some(1.5) });
    assert_eq!((model.cameras[0].near, model.cameras[0].far), (0.1, None));
    assert_eq!(model.cameras[1].projection, Projection::Orthographic { half_width: 2.0, half_height: 1.0 });
    assert_eq!((model.lights[0].kind, model.lights[0].intensity), (LightKind::Directional, 3.0));
    assert_eq!(model.lights[0].color, [1.0, 0.9, 0.8]);
    assert_eq!(model.lights[1].kind, LightKind::Spot { inner_angle: 0.2, outer_angle: 0.4 });
    assert_eq!((model.lights[1].range, model.lights[2].range), (Some(5.0), None));
    let wave = &model.animations[model.animation_named("wave").unwrap()];
    let moved: Vec<_> = wave.channels.iter().map(|c| (c.node, c.property)).collect();
    let wanted = [(1, Property::Translation), (2, Property::Rotation), (2, Property::Scale), (0, Property::Weights)];
    assert_eq!((moved, wave.duration), (wanted.to_vec(), 2.0));
    assert_eq!(wave.curves[wave.channels[3].curve].interpolation, Interpolation::Cubic);
    assert!(model.animation_named("walk").is_none());
}

#[test]
fn a_material_with_everything() {
    let _unmeasured = unmeasured();
    let model = everything().model();
    let all = &model.materials[0];
    assert_eq!((all.name.as_str(), all.double_sided, all.unlit), ("all", true, true));
    assert_eq!(all.base_color.factor, [0.5, 0.6, 0.7]);
    let paint = all.base_color.texture.as_ref().unwrap();
    assert_eq!((paint.name.as_str(), paint.encoding, paint.coordinates), ("paint", Encoding::Srgb, 1));
    assert_eq!(paint.wrap, [TextureWrap::Clamp, TextureWrap::Mirror]);
    assert_eq!([paint.raster.value(1, 0, 1), paint.raster.value(0, 1, 2)], [1.0, 1.0]);
    assert_eq!((all.roughness.factor, all.roughness.channel), (0.75, 1));
    assert_eq!((all.metalness.factor, all.metalness.channel), (0.25, 2));
    let grey = all.roughness.texture.as_ref().unwrap();
    assert_eq!((grey.encoding, grey.coordinates, grey.wrap), (Encoding::Linear, 1, [TextureWrap::Repeat; 2]));
    assert!((grey.raster.value(3, 3, 0) * 255.0 - 90.0).abs() < 3.0, "a JPEG of one grey");
    let Opacity::Mask { mask, cutoff } = &all.opacity else { panic!("a mask") };
    assert_eq!((mask.factor, mask.channel, *cutoff), (0.8, 3, 0.4));
    assert!((mask.texture.as_ref().unwrap().raster.value(0, 1, 3) - 64.0 / 255.0).abs() < 1e-6);
    assert_eq!(all.normal_map.as_ref().unwrap().scale, 0.5);
    assert_eq!((all.occlusion.channel, all.occlusion_strength), (0, 0.3));
    assert!(close(all.emission.factor[2], 3.0) && all.emission.texture.is_some());
    // The F0 of water is 0.0201.
    assert!((all.f0.factor[0] - 0.0201).abs() < 1e-4 && close(all.f0.factor[1], 2.0 * all.f0.factor[0]));
    assert_eq!((all.specular.factor, all.specular.channel), (0.9, 3));
    let anisotropy = all.anisotropy.as_ref().unwrap();
    assert_eq!((anisotropy.strength.factor, anisotropy.strength.channel, anisotropy.rotation), (0.6, 2, 1.5));
    assert_eq!(all.coordinate_sets(), 2);
    // An image shared by several textures is decoded once.
    let emission = all.emission.texture.as_ref().unwrap();
    assert!(std::sync::Arc::ptr_eq(&paint.raster, &emission.raster));
    assert_eq!(model.materials.len(), 1);
}

/// The extension defines the order: first scale, then a counter-clockwise rotation as displayed, then translation.
#[test]
fn texture_transforms_scale_then_turn_then_shift() {
    let _unmeasured = unmeasured();
    let model = everything().model();
    let transform = model.materials[0].base_color.texture.as_ref().unwrap().transform;
    let (sine, cosine) = 0.5f32.sin_cos();
    for texcoord in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.7)] {
        let (u, v) = (2.0 * texcoord.x, 3.0 * texcoord.y);
        let wanted = Vec2::new(cosine * u + sine * v + 0.1, cosine * v - sine * u + 0.2);
        assert!(transform.transform_point2(texcoord).distance(wanted) < 1e-6);
    }
    assert_eq!(model.materials[0].emission.texture.as_ref().unwrap().transform, Affine2::IDENTITY);
}

#[test]
fn missing_normals_give_flat_unshared_vertices() {
    let _unmeasured = unmeasured();
    let mut made = Builder::new();
    // The mesh is a roof of two triangles with a shared edge.
    let positions = made.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 1.0, 0.0, -1.0, -1.0, 0.0, -1.0]);
    let tangents = made.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
    let uv = made.floats("VEC2", &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
    let indices = made.shorts(&[0, 2, 1, 0, 1, 3]);
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uv, "TANGENT": tangents });
    let target = json!({ "POSITION": positions });
    made.push(
        "meshes",
        json!({ "primitives": [{ "attributes": attributes, "indices": indices, "targets": [target] }] }),
    );
    let model = made.model();
    let primitive = &model.meshes[0].primitives[0];
    assert!(primitive.flat && primitive.tangents.is_none());
    assert_eq!(primitive.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(primitive.texcoords[0][5], [0.6, 0.7]);
    assert_eq!(primitive.targets[0].positions, primitive.positions);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for vertex in 0..6 {
        let wanted = Vec3::new(if vertex < 3 { half } else { -half }, 0.0, half);
        assert!(Vec3::from(primitive.normals[vertex]).distance(wanted) < 1e-6, "{vertex}");
    }
}

#[test]
fn the_default_material_is_added_only_where_it_is_used() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let model = made.model();
    assert_eq!((model.materials.len(), model.meshes[0].primitives[0].material), (1, 0));
    assert_eq!((model.materials[0].metalness.factor, model.materials[0].roughness.factor), (1.0, 1.0));
    made.push("materials", json!({}));
    assert_eq!(made.model().meshes[0].primitives[0].material, 1);
    made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    assert_eq!(made.model().materials.len(), 1);
}

/// Attributes accept all of their possible component types.
#[test]
fn component_types_follow_the_specification() {
    let _unmeasured = unmeasured();
    let color = |component: u32, bytes: &[u8]| {
        let mut made = triangle();
        let shape = if component == F32 { "VEC3" } else { "VEC4" };
        let colors = made.accessor(shape, component, 3, bytes);
        made.json["accessors"][colors]["normalized"] = json!(component != F32);
        made.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        made.model().meshes[0].primitives[0].colors.as_ref().unwrap()[1]
    };
    let same = |found: [f32; 4], wanted: [f32; 4]| found.into_iter().zip(wanted).all(|(a, b)| close(a, b));
    assert!(same(color(U8, &[0, 0, 0, 0, 0, 51, 102, 255, 0, 0, 0, 0]), [0.0, 0.2, 0.4, 1.0]));
    let shorts: Vec<u8> =
        [0u16, 0, 0, 0, 0, 13107, 26214, 65535, 0, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert!(same(color(U16, &shorts), [0.0, 0.2, 0.4, 1.0]));
    let floats: Vec<u8> =
        [0.0f32, 0.0, 0.0, 0.5, 0.25, 1.0, 0.0, 0.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(color(F32, &floats), [0.5, 0.25, 1.0, 1.0]);

    // Quantised positions need the extension. The smallest code of a position means -1.
    let mut made = triangle();
    let bytes = [0x80, 0x81, 127, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let positions = made.accessor("VEC3", I8, 3, &bytes);
    made.json["accessors"][positions]["normalized"] = json!(true);
    let view = made.json["accessors"][positions]["bufferView"].as_u64().unwrap() as usize;
    made.json["bufferViews"][view]["byteStride"] = json!(4);
    made.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    let (model, remark) = made.repaired();
    let wanted = "`POSITION` must be VEC3 of floats, but accessor 1 is VEC3 of normalised signed bytes; it is read as normalised";
    assert!(remark.contains(wanted), "{remark}");
    assert_eq!(model.meshes[0].primitives[0].positions[0], [-1.0, -1.0, 1.0]);
    made.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    made.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(made.model().meshes[0].primitives[0].positions[0], [-1.0, -1.0, 1.0]);
    // Without the flag, codes of positions are coordinates, and those of colours and weights are shares.
    made.json["accessors"][positions]["normalized"] = json!(false);
    assert_eq!(made.model().meshes[0].primitives[0].positions[0], [-128.0, -127.0, 127.0]);
    for (name, value) in [("COLOR_0", 0.2), ("WEIGHTS_0", 1.0)] {
        let mut made = triangle();
        let bytes = made.accessor("VEC4", U8, 3, &[51, 0, 0, 0, 51, 0, 0, 0, 51, 0, 0, 0]);
        let joints = made.accessor("VEC4", U8, 3, &[0; 12]);
        let attributes = &mut made.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[name] = json!(bytes);
        if name == "WEIGHTS_0" {
            attributes["JOINTS_0"] = json!(joints);
        }
        let model = made.model();
        assert!(model.remarks[0].contains("is VEC4 of bytes; it is read as normalised numbers"), "{:?}", model.remarks);
        let primitive = &model.meshes[0].primitives[0];
        let found = match &primitive.influences {
            Some(influences) => influences[0].weights[0],
            None => primitive.colors.as_ref().unwrap()[0][0],
        };
        assert!((found - value).abs() < 1e-6, "{name}: {found}");
    }
    // Height scales are an attribute of this program.
    let scales = |values: &[f32; 3]| {
        let mut made = triangle();
        let scales = made.floats("SCALAR", values);
        made.json["meshes"][0]["primitives"][0]["attributes"]["_HEIGHT_SCALE"] = json!(scales);
        made
    };
    let found = |model: &Model| model.meshes[0].primitives[0].height_scales.clone().unwrap();
    assert_eq!(found(&scales(&[0.0, 0.5, 2.0]).model()), [0.0, 0.5, 2.0]);
    for wrong in [-1.0, 1e9] {
        let (model, remark) = scales(&[0.5, wrong, 0.25]).repaired();
        assert!(remark.contains("_HEIGHT_SCALE"), "{remark}");
        assert_eq!(found(&model), [0.5, 1.0, 0.25], "{wrong}");
    }
    for wrong in [f32::NAN, f32::INFINITY] {
        assert_eq!(found(&scales(&[0.5, wrong, 0.25]).model()), [0.5, 1.0, 0.25], "{wrong}");
    }
    // Further numbers of an attribute are ignored, and a missing sign of a tangent is 1.
    let mut made = with_attribute("TEXCOORD_0", "VEC3", &[0.5, 0.25, 9.0].repeat(6));
    let (model, remark) = made.repaired();
    assert!(remark.contains("`TEXCOORD_0` must be VEC2") && remark.contains("its first numbers are read"), "{remark}");
    assert_eq!(model.meshes[0].primitives[0].texcoords[0][1], [0.5, 0.25]);
    made = with_attribute("TANGENT", "VEC3", &[1.0, 0.0, 0.0].repeat(6));
    let normals = made.floats("VEC3", &[0.0, 0.0, 1.0].repeat(6));
    made.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert_eq!(made.repaired().0.meshes[0].primitives[0].tangents.as_ref().unwrap()[1], [1.0, 0.0, 0.0, 1.0]);
    // Morph targets may be normalised even without the extension.
    let mut made = triangle();
    let bytes: Vec<u8> = [32767i16, -32768, 0, 0, 0, 0, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let target = made.accessor("VEC3", I16, 3, &bytes);
    made.json["accessors"][target]["normalized"] = json!(true);
    made.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    assert_eq!(made.model().meshes[0].primitives[0].targets[0].positions[0], [1.0, -1.0, 0.0]);
}

#[test]
fn interleaved_vertices_are_read_by_their_stride() {
    let _unmeasured = unmeasured();
    let mut made = Builder::new();
    let vertex = |i: f32| [i, 10.0 + i, 20.0 + i, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = (0..3).flat_map(|i| vertex(i as f32)).flat_map(f32::to_le_bytes).collect();
    let view = made.view(&bytes);
    made.json["bufferViews"][view]["byteStride"] = json!(24);
    for offset in [0, 12] {
        let accessor =
            json!({ "bufferView": view, "byteOffset": offset, "type": "VEC3", "componentType": F32, "count": 3 });
        made.push("accessors", accessor);
    }
    made.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 } }] }));
    let primitive = &made.model().meshes[0].primitives[0];
    assert_eq!(primitive.positions[2], [2.0, 12.0, 22.0]);
    assert_eq!(primitive.normals, [[0.0, 0.0, 1.0]; 3]);
    assert!(!primitive.flat);
}

#[test]
fn shown_nodes_are_those_of_the_scene() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    for children in [json!([]), json!([3]), json!([])] {
        made.push("nodes", json!({ "children": children }));
    }
    let all = |made: &Builder| -> Vec<usize> {
        let mut shown = made.model().shown_nodes();
        shown.sort_unstable();
        shown
    };
    assert_eq!(all(&made), [0, 1, 2, 3]);
    made.push("scenes", json!({ "nodes": [2] }));
    assert_eq!(all(&made), [2, 3]);
    made.push("scenes", json!({ "nodes": [0, 2, 2] }));
    made.json["scene"] = json!(1);
    assert_eq!(all(&made), [0, 2, 3]);
    assert_eq!(made.model().scenes[1].roots, [0, 2]);
}

#[test]
fn empty_model_is_valid() {
    let _unmeasured = unmeasured();
    let model = Builder::new().model();
    assert_eq!(model, Model { name: "made".into(), ..Model::default() });
    assert!(model.shown_nodes().is_empty() && model.pose(None, 0.0).world_from_node.is_empty());
    assert_eq!(Transform::IDENTITY.matrix(), Mat4::IDENTITY);
}
