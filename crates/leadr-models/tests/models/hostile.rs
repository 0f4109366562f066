//! Tests of models that violate one rule each. The models are refused in one line with the name of the part, or repaired
//! with a remark.

use leadr_models::Model;
use serde_json::{Value, json};

use crate::build::{Builder, U8, U16, U32, decode, decode_strictly, everything, glb, triangle};
use leadr_testing::memory::unmeasured;

/// A change to the model that has every feature, and the expected error.
struct Case(&'static str, fn(&mut Value), &'static str);

/// Each case is the smallest change that violates its rule. [`the_unchanged_model_loads`] shows that the rest of the model
/// is valid.
const CASES: [Case; 61] = [
    Case("no asset", |m| drop(m.as_object_mut().unwrap().remove("asset")), "the model: `asset` is missing"),
    Case("version 1", |m| m["asset"]["version"] = json!("1.0"), "it is glTF 1.0; export it as glTF 2.0"),
    Case("version in words", |m| m["asset"]["version"] = json!("two"), "asset: `two` is not a version"),
    Case(
        "required extension",
        |m| m["extensionsRequired"] = json!(["XYZ_shape"]),
        "XYZ_shape; export it without, or load",
    ),
    Case("list of the wrong type", |m| m["skins"] = json!({}), "the model: `skins` must be an array"),
    Case("object of the wrong type", |m| m["nodes"][2] = json!(7), "node 2: must be an object"),
    Case("name of the wrong type", |m| m["nodes"][2]["name"] = json!(7), "node 2: `name` must be a string"),
    Case(
        "buffer of no length",
        |m| m["buffers"][0]["byteLength"] = json!(0),
        "buffer 0: `byteLength` must be 1 or more",
    ),
    Case(
        "buffer too long",
        |m| m["buffers"][0]["byteLength"] = json!(1 << 20),
        "buffer 0: `byteLength` is 1048576, but there are",
    ),
    Case(
        "buffer beyond the limit",
        |m| m["buffers"][0]["byteLength"] = json!(1u64 << 40),
        "its buffers have 1024 GiB or more",
    ),
    Case(
        "view of no buffer",
        |m| m["bufferViews"][1]["buffer"] = json!(1),
        "buffer view 1: `buffer` refers to buffer 1, but there are only 1",
    ),
    Case(
        "view beyond its buffer",
        |m| m["bufferViews"][1]["byteLength"] = json!(1 << 20),
        "buffer view 1: needs bytes",
    ),
    Case(
        "view that wraps round",
        |m| m["bufferViews"][1]["byteOffset"] = json!(u64::MAX),
        "buffer view 1: needs bytes",
    ),
    Case(
        "negative offset",
        |m| m["bufferViews"][1]["byteOffset"] = json!(-4),
        "buffer view 1: `byteOffset` must be a whole number",
    ),
    Case(
        "odd stride",
        |m| m["bufferViews"][3]["byteStride"] = json!(5),
        "buffer view 3: `byteStride` must be a multiple of 4",
    ),
    Case("accessor of nothing", |m| m["accessors"][0]["count"] = json!(0), "accessor 0: `count` must be 1 or more"),
    Case(
        "accessor too long",
        |m| m["accessors"][0]["count"] = json!(5),
        "accessor 0: 5 elements need bytes 0 to 60, but the buffer view has 48",
    ),
    Case(
        "accessor of 2^31",
        |m| m["accessors"][0]["count"] = json!(1u64 << 31),
        "accessor 0: 2147483648 elements need bytes 0 to 25769803776",
    ),
    Case(
        "accessor of 2^64",
        |m| m["accessors"][0]["count"] = json!(u64::MAX),
        "accessor 0: 18446744073709551615 elements need",
    ),
    Case("half an element", |m| m["accessors"][0]["count"] = json!(3.5), "accessor 0: `count` must be a whole number"),
    Case(
        "stride below an element",
        |m| m["bufferViews"][2]["byteStride"] = json!(8),
        "accessor 0: an element has 12 bytes, but `byteStride` is 8",
    ),
    Case(
        "sparse beyond its base",
        |m| sparse(m)["count"] = json!(5),
        "sparse: `count` is 5, but must be from 1 to 4, the number of elements",
    ),
    Case("sparse of 2^63", |m| sparse(m)["count"] = json!(1u64 << 63), "sparse: `count` is 9223372036854775808"),
    Case(
        "sparse indices of floats",
        |m| sparse(m)["indices"]["componentType"] = json!(5126),
        "indices: `componentType` must be 5121, 5123 or 5125",
    ),
    Case("sparse indices backwards", |m| sparse(m)["indices"]["byteOffset"] = json!(1), "sparse, indices: "),
    Case(
        "sparse values beyond",
        |m| sparse(m)["values"]["byteOffset"] = json!(4),
        "values: 2 elements need bytes 4 to 28, but the buffer view has 24",
    ),
    Case(
        "positions of two numbers",
        |m| attributes(m)["POSITION"] = json!(3),
        "`POSITION` must be VEC3 of floats, but accessor 3 is VEC2 of floats",
    ),
    Case(
        "positions of nothing",
        |m| attributes(m)["POSITION"] = json!(99),
        "attributes: `POSITION` refers to accessor 99, but there are only",
    ),
    Case(
        "fewer normals",
        |m| m["accessors"][1]["count"] = json!(3),
        "attributes: `NORMAL` has 3 elements, but `POSITION` has 4",
    ),
    Case(
        "joints without weights",
        |m| drop(attributes(m).as_object_mut().unwrap().remove("WEIGHTS_0")),
        "`JOINTS_0` and `WEIGHTS_0` must be given together",
    ),
    Case(
        "joints of floats",
        |m| attributes(m)["JOINTS_0"] = json!(2),
        "`JOINTS_0` must be VEC4 of unsigned bytes or 16-bit numbers",
    ),
    Case("unknown mode", |m| primitive(m)["mode"] = json!(7), "primitive 0: `mode` is 7, but must be 0 to 6"),
    Case(
        "indices of floats",
        |m| primitive(m)["indices"] = json!(0),
        "`indices` must be SCALAR of unsigned numbers, but accessor 0 is VEC3 of floats",
    ),
    Case(
        "no material",
        |m| primitive(m)["material"] = json!(1),
        "primitive 0: `material` refers to material 1, but there are only 1",
    ),
    Case("no primitives", |m| m["meshes"][0]["primitives"] = json!([]), "mesh 0: has no primitives"),
    Case(
        "weights for other targets",
        |m| m["meshes"][0]["weights"] = json!([0.5, 0.5]),
        "mesh 0: has 2 weights for 1 morph targets",
    ),
    Case(
        "joint beyond the skin",
        |m| m["skins"][0]["joints"] = json!([1]),
        "node 0: mesh 0, primitive 0 follows joint 1, but skin 0 has 1 joints",
    ),
    Case("joint twice", |m| m["skins"][0]["joints"] = json!([1, 1]), "skin 0: has node 1 as two of its joints"),
    Case(
        "too few bind matrices",
        |m| m["accessors"][10]["count"] = json!(1),
        "skin 0: has 2 joints, but 1 inverse bind matrices",
    ),
    Case("two parents", |m| m["nodes"][0]["children"] = json!([2]), "node 2: is a child of node 0 and of node 1"),
    Case("own parent", |m| m["nodes"][2]["children"] = json!([2]), "node 2: is its own child"),
    Case(
        "own ancestor",
        |m| {
            m["nodes"][2]["children"] = json!([4]);
            m["nodes"].as_array_mut().unwrap().push(json!({ "children": [1] }));
            m["scenes"][0]["nodes"] = json!([0]);
        },
        "node 1: is its own ancestor",
    ),
    Case(
        "scene of children",
        |m| m["scenes"][0]["nodes"] = json!([2]),
        "scene 0: lists node 2, which is not a root but a child of node 1",
    ),
    Case("no such scene", |m| m["scene"] = json!(1), "the model: `scene` refers to scene 1, but there are only 1"),
    Case("matrix and parts", |m| m["nodes"][3]["scale"] = json!([1, 1, 1]), "node 3: has both a `matrix` and"),
    Case(
        "matrix that is not affine",
        |m| m["nodes"][3]["matrix"][3] = json!(1),
        "node 3: `matrix` has 1 in its last row",
    ),
    Case(
        "matrix beyond floats",
        |m| m["nodes"][3]["matrix"][0] = json!(1e300),
        "node 3: `matrix` must be an array of numbers",
    ),
    Case(
        "rotation of no length",
        |m| m["nodes"][2]["rotation"] = json!([0, 0, 0, 0]),
        "node 2: `rotation` has zero length",
    ),
    Case("scale of two", |m| m["nodes"][2]["scale"] = json!([1, 1]), "node 2: `scale` must be an array of 3 numbers"),
    Case(
        "metal beyond 1",
        |m| m["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(1.5),
        "material 0, pbrMetallicRoughness: `metallicFactor` must be a number from 0 to 1",
    ),
    Case(
        "no texture",
        |m| m["materials"][0]["normalTexture"]["index"] = json!(9),
        "material 0, normalTexture: `index` refers to texture 9",
    ),
    Case(
        "index of refraction below 1",
        |m| m["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = json!(0.5),
        "`ior` is 0.5, but must be 0, or at least 1",
    ),
    Case(
        "wrap of nothing",
        |m| m["samplers"][0]["wrapS"] = json!(1),
        "sampler 0: `wrapS` is 1, but must be 10497, 33648 or 33071",
    ),
    Case("camera without kind", |m| m["cameras"][0]["type"] = json!("fisheye"), "camera 0: `type` fisheye is unknown"),
    Case(
        "far before near",
        |m| m["cameras"][1]["orthographic"]["znear"] = json!(11),
        "camera 1: `zfar` must be above `znear`",
    ),
    Case(
        "cone inside out",
        |m| m["extensions"]["KHR_lights_punctual"]["lights"][1]["spot"]["innerConeAngle"] = json!(0.5),
        "light 1, spot: `innerConeAngle` 0.5 must be below",
    ),
    Case(
        "animated matrix",
        |m| m["animations"][0]["channels"][0]["target"]["node"] = json!(3),
        "channel 0, target: animates node 3, which has a matrix",
    ),
    Case(
        "weights of nothing",
        |m| m["animations"][0]["channels"][3]["target"]["node"] = json!(1),
        "animates the weights of node 1, which has no morph targets",
    ),
    Case(
        "values of another kind",
        |m| m["animations"][0]["channels"][0]["target"]["path"] = json!("rotation"),
        "animation 0, sampler 0: `output` must be VEC4 of floats",
    ),
    Case(
        "too few values",
        |m| m["animations"][0]["samplers"][2]["interpolation"] = json!("LINEAR"),
        "animation 0, sampler 2: has 9 values for 3 keys, but needs 3",
    ),
    Case(
        "unknown interpolation",
        |m| m["animations"][0]["samplers"][1]["interpolation"] = json!("BEZIER"),
        "animation 0, sampler 1: `interpolation` BEZIER is unknown",
    ),
];

fn sparse(model: &mut Value) -> &mut Value {
    model["accessors"].as_array_mut().unwrap().iter_mut().find_map(|a| a.get_mut("sparse")).unwrap()
}

fn primitive(model: &mut Value) -> &mut Value {
    &mut model["meshes"][0]["primitives"][0]
}

fn attributes(model: &mut Value) -> &mut Value {
    &mut primitive(model)["attributes"]
}

#[test]
fn the_unchanged_model_loads() {
    let _unmeasured = unmeasured();
    let made = everything();
    decode(&glb(made.finished().to_string().as_bytes(), &made.binary)).unwrap();
}

/// The cases that have no plain reading, because nothing is left to draw or the nodes form a cycle.
const BEYOND_REPAIR: [&str; 15] = [
    "version 1",
    "list of the wrong type",
    "buffer beyond the limit",
    "accessor of nothing",
    "accessor too long",
    "accessor of 2^31",
    "accessor of 2^64",
    "half an element",
    "stride below an element",
    "positions of two numbers",
    "positions of nothing",
    "unknown mode",
    "indices of floats",
    "no primitives",
    "own ancestor",
];

#[test]
fn every_broken_rule_is_one_line_that_names_the_part() {
    let _unmeasured = unmeasured();
    let made = everything();
    let mut wrong = Vec::new();
    for Case(name, change, wanted) in CASES {
        let mut json = made.finished();
        change(&mut json);
        let file = glb(json.to_string().as_bytes(), &made.binary);
        let message = match decode_strictly(&file) {
            Ok(_) => panic!("{name} was accepted"),
            Err(fault) => fault.to_string(),
        };
        println!("{name}: {message}");
        if !message.contains(wanted) {
            wrong.push(format!("{name}: {message}"));
        }
        assert!(message.contains("; ") && !message.contains('\n') && message.len() < 500, "{name}: {message}");
        let what = wanted.split("; ").next().unwrap();
        let (refused, messages) = match decode(&file) {
            Ok(model) => (false, model.remarks),
            Err(fault) => (true, vec![fault.to_string()]),
        };
        println!("    {messages:?}");
        if refused != BEYOND_REPAIR.contains(&name) || !messages.iter().any(|message| message.contains(what)) {
            wrong.push(format!("{name}: {} {messages:?}", if refused { "refused" } else { "accepted" }));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Builds two triangles with an attribute of six values.
pub fn with_attribute(name: &str, shape: &str, numbers: &[f32]) -> Builder {
    let mut made = Builder::new();
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let positions = made.floats("VEC3", &[corners, corners].concat());
    made.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
    made.push("nodes", json!({ "mesh": 0 }));
    let accessor = made.floats(shape, numbers);
    made.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    made
}

/// The test alters numbers in the binary data, which changes to the JSON cannot corrupt.
#[test]
fn meaningless_numbers_are_left_out() {
    let _unmeasured = unmeasured();
    let primitive = |model: &Model| model.meshes[0].primitives[0].clone();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let mut positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].repeat(2);
        positions[3] = bad;
        let made = with_attribute("POSITION", "VEC3", &positions);
        let model = made.model();
        assert_eq!(primitive(&model).triangles.len(), 1);
        assert!(model.remarks[0].contains(&format!("`POSITION` of vertex 1 is {bad}")), "{:?}", model.remarks);
        assert!(decode_strictly(&made.glb()).is_err());
        // Nothing is left of a single triangle.
        positions.truncate(9);
        let fault = with_attribute("POSITION", "VEC3", &positions).fault();
        assert!(fault.contains("`POSITION` of vertex 1 is"), "{fault}");

        let mut directions = [0.0, 0.0, 1.0].repeat(6);
        directions[3] = bad;
        let made = with_attribute("NORMAL", "VEC3", &directions);
        let normal = glam::Vec3::from(primitive(&made.model()).normals[1]);
        assert!(normal.distance(if bad == 1e30 { glam::Vec3::X } else { glam::Vec3::Z }) < 1e-6, "{bad}: {normal}");
        assert!(made.model().remarks.len() == 1 && decode_strictly(&made.glb()).is_err());

        let mut texcoords = vec![0.5; 12];
        texcoords[2] = bad;
        let made = with_attribute("TEXCOORD_0", "VEC2", &texcoords);
        assert_eq!(primitive(&made.model()).texcoords[0][..2], [[0.5, 0.5], [0.0, 0.0]]);
        assert!(made.model().remarks.len() == 1 && decode_strictly(&made.glb()).is_err());

        let mut weights = [0.5, 0.5, 0.0, 0.0].repeat(6);
        weights[5] = -bad;
        let mut made = with_attribute("WEIGHTS_0", "VEC4", &weights);
        let joints = made.accessor("VEC4", U8, 6, &[0; 24]);
        made.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        assert_eq!(primitive(&made.model()).influences.unwrap()[1].weights, [1.0, 0.0, 0.0, 0.0]);
        assert!(decode_strictly(&made.glb()).is_err());
    }

    for index in [6u32, 0x7fff_ffff, 0x8000_0000, u32::MAX] {
        let mut made = with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(6));
        let bytes: Vec<u8> = [0, 1, index, 3, 4, 5].iter().flat_map(|v: &u32| v.to_le_bytes()).collect();
        let indices = made.accessor("SCALAR", U32, 6, &bytes);
        made.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        let (model, remark) = made.repaired();
        assert_eq!(primitive(&model).triangles, [[3, 4, 5]]);
        let wanted = format!("1 of 2 triangles refer to vertices such as {index}, but there are only 6");
        assert!(remark.contains(&wanted), "{remark}");
    }
    // The scales are valid alone, but overflow when nested.
    let mut made = Builder::new();
    for node in 0..8 {
        let children: Vec<usize> = (node + 1..8).take(1).collect();
        made.push("nodes", json!({ "scale": [1e10, 1e10, 1e10], "children": children }));
    }
    assert!(made.fault().contains("node 3: is scaled or moved so far"), "{}", made.fault());
}

/// The keys of animations may be in any order and at any time, and those without numbers are left out.
#[test]
fn unusual_keys_of_animations_are_played() {
    let _unmeasured = unmeasured();
    let animated = |times: &[f32], values: &[f32], interpolation: &str| {
        let mut made = triangle();
        let (input, output) = (made.floats("SCALAR", times), made.floats("VEC3", values));
        let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
        let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
        made.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
        made
    };
    let x = |model: &Model, seconds: f32| model.pose(Some(0), seconds).world_from_node[0].w_axis.x;
    let slide: Vec<f32> = [0.0, 1.0, 2.0].iter().flat_map(|&x| [x, 0.0, 0.0]).collect();
    let cases: [(&[f32], &str, [f32; 3]); 5] = [
        (&[0.0, 1.0, 1.0], "time 2 is 1 after 1, but times must increase; the keys are sorted", [0.5, 2.0, 2.0]),
        (&[0.0, 2.0, 1.0], "time 2 is 1 after 2", [1.0, 2.0, 1.0]),
        (&[-1.0, 1.0, 2.0], "its first time is -1, but must be at least 0", [0.75, 1.0, 2.0]),
        (&[0.0, f32::NAN, 2.0], "1 keys are not numbers", [0.5, 1.0, 2.0]),
        (&[0.0, 1.0, f32::INFINITY], "1 keys are not numbers", [0.5, 1.0, 1.0]),
    ];
    for (times, wanted, at) in cases {
        let (model, remark) = animated(times, &slide, "LINEAR").repaired();
        assert!(remark.contains(wanted), "{remark}");
        assert_eq!([0.5, 1.0, 2.0].map(|seconds| x(&model, seconds)), at, "{times:?}");
    }
    let (model, remark) = animated(&[1.0], &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0], "CUBICSPLINE").repaired();
    assert!(remark.contains("is a cubic spline with one key"), "{remark}");
    assert_eq!(x(&model, 0.0), 3.0);
    let (model, remark) = animated(&[0.0, 1.0], &slide, "LINEAR").repaired();
    assert!(remark.contains("has 3 values for 2 keys") && model.animations.is_empty(), "{remark}");
    let mut turned = triangle();
    let (input, output) = (turned.floats("SCALAR", &[0.0, 1.0]), turned.floats("VEC4", &[0.0; 8]));
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "rotation" } });
    turned.push("animations", json!({ "samplers": [{ "input": input, "output": output }], "channels": [channel] }));
    assert!(turned.repaired().1.contains("the rotation of key 0 has zero length"));
    // A matrix is split, unless it has a shear.
    for (shear, channels) in [(0.0, 1), (0.5, 0)] {
        let mut made = animated(&[0.0, 1.0, 2.0], &slide, "LINEAR");
        let matrix = [0.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, shear, 0.0, 2.0, 0.0, 5.0, 0.0, 0.0, 1.0];
        made.json["nodes"][0]["matrix"] = json!(matrix);
        let (model, remark) = made.repaired();
        assert!(remark.contains("animates node 0, which has a matrix"), "{remark}");
        assert_eq!(model.animations.iter().map(|animation| animation.channels.len()).sum::<usize>(), channels);
        let turned = model.pose(None, 0.0).world_from_node[0].transform_vector3(glam::Vec3::X);
        assert!(turned.distance(2.0 * glam::Vec3::Y) < 1e-5, "{turned}");
    }
}

#[test]
fn repairs_are_remarked_on() {
    let _unmeasured = unmeasured();
    let repaired = |change: fn(&mut Builder)| {
        let mut made = everything();
        change(&mut made);
        made.repaired()
    };
    let (model, remark) = repaired(|m| m.json["nodes"][2]["rotation"] = json!([0, 0, 3, 4]));
    assert!(remark.contains("node 2: `rotation` has the length 5, which must be 1; it is scaled"), "{remark}");
    let turned = model.nodes[2].transform.matrix().transform_vector3(glam::Vec3::X);
    assert!((turned.length() - 2.0).abs() < 1e-5, "{turned}");
    let (model, remark) = repaired(|m| m.json["materials"][0]["alphaMode"] = json!("FROSTED"));
    assert!(remark.contains("alpha mode FROSTED is unknown"));
    assert_eq!(model.materials[0].opacity, leadr_maps::material::Opacity::Opaque);
    let (model, remark) =
        repaired(|m| m.json["animations"][0]["channels"][2]["target"] = json!({ "node": 1, "path": "translation" }));
    assert!(remark.contains("it replaces the earlier one"));
    assert_eq!(model.animations[0].channels.len(), 3);
    let (_, remark) = repaired(|m| {
        m.json["nodes"][0].as_object_mut().unwrap().remove("mesh");
        m.json.as_object_mut().unwrap().remove("animations");
    });
    assert!(remark.contains("node 0: has a skin or weights, but no mesh"), "{remark}");
    let (model, _) = repaired(|m| m.json["materials"][0]["emissiveFactor"] = json!([0.5, 2.0, 1.0]));
    assert_eq!(model.materials[0].emission.factor, [5.0, 20.0, 10.0], "ten times as strong by the extension");
    let (model, _) = repaired(|m| m.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(1.0001));
    assert_eq!(model.materials[0].roughness.factor, 1.0);
    let (model, _) = repaired(|m| m.json["nodes"][0]["children"] = json!([2]));
    assert_eq!((model.nodes[2].parent, &model.nodes[1].children[..]), (Some(0), &[3][..]));
    let (model, _) = repaired(|m| m.json["skins"][0]["joints"] = json!([1]));
    let influences = &model.meshes[0].primitives[0].influences.as_ref().unwrap()[2];
    assert_eq!((influences.joints, influences.weights), ([0; 4], [1.0, 0.0, 0.0, 0.0]));

    // These are no violations.
    let remark = |change: fn(&mut Builder)| {
        let mut made = everything();
        change(&mut made);
        made.model().remarks.join("\n")
    };
    let pointer = remark(|m| m.json["animations"][0]["channels"][0]["target"]["path"] = json!("pointer"));
    assert!(pointer.contains("animates `pointer`, which is not supported"), "{pointer}");
    let sheen = remark(|m| m.json["extensionsUsed"] = json!(["KHR_materials_sheen"]));
    assert!(sheen.contains("unsupported extensions: KHR_materials_sheen"), "{sheen}");
    let wide = remark(|m| m.json["cameras"][0]["perspective"]["yfov"] = json!(4.0));
    assert!(wide.contains("`yfov` is 4"), "{wide}");
}

/// A model with many defects of one kind has one remark.
#[test]
fn remarks_of_one_kind_are_joined() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let points = json!({ "attributes": { "POSITION": 0 }, "mode": 0 });
    made.json["meshes"][0]["primitives"].as_array_mut().unwrap().extend(vec![points; 500]);
    for number in 0..100 {
        made.push("nodes", json!({ "children": [1000 + number] }));
    }
    let remarks = made.model().remarks;
    assert_eq!(remarks.len(), 2, "{remarks:?}");
    let points = "mesh 0, primitive 1: consists of points, which are not drawn (and 499 more like this)";
    assert!(remarks.iter().any(|remark| remark == points), "{remarks:?}");
    assert!(remarks.iter().any(|remark| remark.ends_with("(and 99 more like this)")), "{remarks:?}");
}

#[test]
fn messages_stay_on_one_line_for_any_name() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let name = format!("a\n\u{1b}[31m{}", "b".repeat(1000));
    made.json["extensionsRequired"] = json!([name]);
    let message = made.model().remarks[0].clone();
    assert!(!message.contains(['\n', '\u{1b}']) && message.len() < 500, "{message}");
    let unused = made.push("accessors", json!({ "type": name, "componentType": U16, "count": 1 }));
    made.json["extensionsRequired"] = json!([]);
    made.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(unused);
    assert!(made.fault().contains("accessor 1 is an unknown type of 16-bit numbers"), "{}", made.fault());
}
