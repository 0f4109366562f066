//! Tests which names that Rust and the shaders share are accepted.

use leadr_gpu::{
    Buffer, Commands, ComputePipeline, Descriptor, GraphicsDesc, GraphicsPipeline, Memory, SharedStruct, SpecValue,
    StructLayout,
};

use leadr_testing::gpu::{Count, TestGpu, test_gpu};

const DOUBLE: &str = "probes/selftest/selftest.comp";
const UNUSED: &str = "probes/selftest/selftest_unused.comp";

fn compute_error(gpu: &TestGpu, shader: &str, spec: &[(&str, SpecValue)], structs: &[StructLayout]) -> String {
    ComputePipeline::new(gpu, shader, spec, structs).map(drop).unwrap_err().to_string()
}

fn says(error: &str, words: &[&str]) {
    assert!(words.iter().all(|word| error.contains(word)), "{error}: not {words:?}");
}

#[test]
fn resources_are_bound_by_name_and_refusals_list_the_names() {
    let Some(gpu) = test_gpu() else { return };
    let double = ComputePipeline::new(&gpu, DOUBLE, &[], &[Count::LAYOUT]).unwrap();
    let buffer = Buffer::new(&gpu, "b", 64, Memory::Device).unwrap();
    let [input, output] = ["In", "Out"].map(|name| (name, Descriptor::Storage(&buffer)));
    type Resources<'a> = &'a [(&'a str, Descriptor<'a>)];
    let cases: [(Resources<'_>, &[&str]); 4] = [
        (&[input], &["selftest.comp", "Out", "storage buffer", "not given"]),
        (&[input, ("Out", Descriptor::Uniform(&buffer))], &["Out is a storage buffer, not a uniform buffer"]),
        (&[input, output, ("Output", Descriptor::Storage(&buffer))], &["no resource Output", "they declare In, Out"]),
        (&[input, output, output], &["Out was given twice"]),
    ];
    for (resources, words) in cases {
        let error = gpu.submit("misuse", |cmd| cmd.bind(&double, resources)).unwrap_err().to_string();
        says(&error, words);
    }
}

#[test]
fn names_may_come_in_any_order() {
    let Some(gpu) = test_gpu() else { return };
    let double = ComputePipeline::new(&gpu, DOUBLE, &[], &[Count::LAYOUT]).unwrap();
    let input = Buffer::from_slice(&gpu, "input", &[21.0f32]).unwrap();
    let output = Buffer::new(&gpu, "output", 4, Memory::Device).unwrap();
    gpu.submit("double", |cmd| {
        cmd.bind(&double, &[("Out", Descriptor::Storage(&output)), ("In", Descriptor::Storage(&input))]);
        cmd.push_constants(&Count { count: 1 });
        cmd.dispatch([1, 1, 1]);
    })
    .unwrap();
    assert_eq!(output.read_all::<f32>().unwrap(), [42.0]);
}

/// A variant of a shader may leave out unused resources, but recording code may still bind them.
#[test]
fn unused_declarations_may_be_bound() {
    let Some(gpu) = test_gpu() else { return };
    let spec = [("UNUSED_FACTOR", SpecValue::F32(2.0))];
    let pipeline = ComputePipeline::new(&gpu, UNUSED, &spec, &[Count::LAYOUT]).unwrap();
    let output = Buffer::new(&gpu, "output", 4, Memory::Device).unwrap();
    let run = |names: &[&str]| {
        let resources: Vec<_> = names.iter().map(|name| (*name, Descriptor::Storage(&output))).collect();
        gpu.submit("unused", |cmd| {
            cmd.bind(&pipeline, &resources);
            cmd.push_constants(&Count { count: 1 });
            cmd.dispatch([1, 1, 1]);
        })
        .unwrap();
    };
    run(&["Out"]);
    run(&["In", "Out"]);
    assert_eq!(output.read_all::<f32>().unwrap(), [1.0]);
}

#[test]
fn constants_are_set_by_name_and_type() {
    let Some(gpu) = test_gpu() else { return };
    let shader = "probes/selftest/selftest_spec.comp";
    says(
        &compute_error(&gpu, shader, &[("SCAEL", SpecValue::F32(1.0))], &[]),
        &["selftest_spec.comp", "no constant SCAEL", "LIMIT, NEGATE, SCALE, SHIFT"],
    );
    says(&compute_error(&gpu, shader, &[("SHIFT", SpecValue::U32(1))], &[]), &["SHIFT is I32, not U32"]);
    let twice = [("SCALE", SpecValue::F32(1.0)), ("SCALE", SpecValue::F32(2.0))];
    says(&compute_error(&gpu, shader, &twice, &[]), &["SCALE is given twice"]);
    says(&compute_error(&gpu, DOUBLE, &[("SCALE", SpecValue::F32(1.0))], &[]), &["no constant SCALE", "none"]);
}

mod wrong {
    leadr_gpu::shared_struct! { pub struct Renamed for "P" { pub number: u32 } }
    leadr_gpu::shared_struct! { pub struct Moved for "P" { pub padding: u32, pub count: u32 } }
    leadr_gpu::shared_struct! { pub struct Longer for "P" { pub count: u32, pub limit: u32 } }
    leadr_gpu::shared_struct! { pub struct Wider for "P" { pub count: [u32; 2] } }
    leadr_gpu::shared_struct! { pub struct Stranger for "Q" { pub count: u32 } }
    leadr_gpu::shared_struct! { pub struct Twin for "P" { pub count: u32 } }
}

#[test]
fn structs_that_do_not_agree_are_refused_with_the_difference() {
    let Some(gpu) = test_gpu() else { return };
    let refused = |structs: &[StructLayout], words: &[&str]| says(&compute_error(&gpu, DOUBLE, &[], structs), words);
    refused(&[], &["selftest.comp", "struct P", "no twin in Rust"]);
    refused(&[wrong::Renamed::LAYOUT], &["struct P", "wrong::Renamed", "member count is number in Rust"]);
    refused(&[wrong::Moved::LAYOUT], &["count is 4 bytes at 0 in GLSL, 4 bytes at 4 in Rust"]);
    refused(&[wrong::Longer::LAYOUT], &["GLSL has no member limit"]);
    refused(&[wrong::Wider::LAYOUT], &["count is 4 bytes at 0 in GLSL, 8 bytes at 0 in Rust"]);
    refused(&[Count::LAYOUT, wrong::Stranger::LAYOUT], &["no shader declares a struct Q", "wrong::Stranger"]);
}

#[test]
fn push_constants_are_of_the_type_that_the_pipeline_was_made_with() {
    let Some(gpu) = test_gpu() else { return };
    let double = ComputePipeline::new(&gpu, DOUBLE, &[], &[Count::LAYOUT]).unwrap();
    let buffer = Buffer::new(&gpu, "b", 64, Memory::Device).unwrap();
    let both = ["In", "Out"].map(|name| (name, Descriptor::Storage(&buffer)));
    let error = gpu.submit("misuse", |cmd| {
        cmd.bind(&double, &both);
        cmd.push_constants(&wrong::Twin { count: 1 });
    });
    says(&error.unwrap_err().to_string(), &["selftest.comp", "gpu::Count", "wrong::Twin"]);
}

#[test]
fn stages_agree_on_resource_names() {
    let Some(gpu) = test_gpu() else { return };
    let desc = GraphicsDesc {
        vertex: "probes/selftest/selftest.vert",
        fragment: Some("probes/selftest/selftest_conflict.frag"),
        ..Default::default()
    };
    let error = GraphicsPipeline::new(&gpu, "conflict", &desc).map(drop).unwrap_err().to_string();
    says(&error, &["conflict", "no twin"]);
    let desc = GraphicsDesc { structs: &[Corner::LAYOUT], ..desc };
    let error = GraphicsPipeline::new(&gpu, "conflict", &desc).map(drop).unwrap_err().to_string();
    says(&error, &["conflict", "Corners is a storage buffer in one stage and a texture in"]);
}

leadr_gpu::shared_struct! {
    struct Corner for "P" {
        color: [f32; 4],
        depth: f32,
    }
}

#[test]
fn misuse_error_contains_the_name() {
    let Some(gpu) = test_gpu() else { return };
    let buffer = Buffer::new(&gpu, "b", 64, Memory::Device).unwrap();
    type Misuse<'a> = Box<dyn Fn(&mut Commands) + 'a>;
    let cases: [(&str, Misuse<'_>); 4] = [
        ("no COMPUTE pipeline", Box::new(|cmd| cmd.dispatch([1, 1, 1]))),
        ("no pipeline is bound", Box::new(|cmd| cmd.push_constants(&Count { count: 1 }))),
        ("do not fit", Box::new(|cmd| cmd.copy_buffer(&buffer, 32, &buffer, 0, 64))),
        ("no attachment", Box::new(|cmd| cmd.begin_rendering(&[], None))),
    ];
    for (words, record) in cases {
        let error = gpu.submit("misuse", |cmd| record(cmd)).unwrap_err().to_string();
        says(&error, &[words]);
    }
    says(&compute_error(&gpu, "probes/absent.comp", &[], &[]), &["absent.comp", "shaders-glsl"]);
    says(&compute_error(&gpu, "probes/selftest/selftest.frag", &[], &[]), &["Fragment"]);
}
