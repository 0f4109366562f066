//! Tests which pipelines share their Vulkan objects.

use leadr_gpu::{ComputePipeline, Depth, GraphicsDesc, GraphicsPipeline, Pipeline, SharedStruct, SpecValue, vk};

use leadr_testing::gpu::{Count, test_gpu};

use super::device::{FLOATS, Push};

fn raw(pipeline: &dyn Pipeline) -> vk::Pipeline {
    pipeline.core().raw()
}

#[test]
fn the_same_code_is_compiled_once() {
    let Some(gpu) = test_gpu() else { return };
    let doubled = || raw(&ComputePipeline::new(&gpu, "probes/selftest/selftest.comp", &[], &[Count::LAYOUT]).unwrap());
    let scaled = |factor: f32| {
        let spec = [("UNUSED_FACTOR", SpecValue::F32(factor))];
        raw(&ComputePipeline::new(&gpu, "probes/selftest/selftest_unused.comp", &spec, &[Count::LAYOUT]).unwrap())
    };
    // Nobody holds the first pipeline when the second one is created.
    assert_eq!(doubled(), doubled());
    assert_eq!(scaled(2.0), scaled(2.0));
    assert_ne!(scaled(2.0), scaled(3.0));
    assert_ne!(scaled(2.0), doubled());
}

#[test]
fn pipelines_with_different_states_differ() {
    let Some(gpu) = test_gpu() else { return };
    let make = |desc: &GraphicsDesc<'_>| raw(&GraphicsPipeline::new(&gpu, "state", desc).unwrap());
    let depth = Depth::default();
    let desc = GraphicsDesc {
        vertex: "probes/selftest/selftest.vert",
        fragment: Some("probes/selftest/selftest.frag"),
        colors: &[FLOATS],
        depth: Some(depth),
        structs: &[Push::LAYOUT],
        ..Default::default()
    };
    let all = [
        desc,
        GraphicsDesc { colors: &[FLOATS, FLOATS], kept_colors: 1, ..desc },
        GraphicsDesc { colors: &[vk::Format::R16G16B16A16_SFLOAT], ..desc },
        GraphicsDesc { samples: 4, ..desc },
        GraphicsDesc { clockwise_front: true, ..desc },
        GraphicsDesc { front_only: true, ..desc },
        GraphicsDesc { wires: true, ..desc },
        GraphicsDesc { depth: None, ..desc },
        GraphicsDesc { depth: Some(Depth { write: false, ..depth }), ..desc },
        GraphicsDesc { depth: Some(Depth { compare: vk::CompareOp::ALWAYS, ..depth }), ..desc },
        GraphicsDesc { depth: Some(Depth { bias: Some([0.0, 0.0]), ..depth }), ..desc },
        GraphicsDesc { depth: Some(Depth { bias: Some([0.0, 1.0]), ..depth }), ..desc },
    ];
    let made = all.map(|desc| make(&desc));
    assert_eq!(all.map(|desc| make(&desc)), made);
    for (i, one) in made.iter().enumerate() {
        assert!(!made[..i].contains(one), "{:?}", all[i]);
    }
}
