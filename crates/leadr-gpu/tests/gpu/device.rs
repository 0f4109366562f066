//! Tests Vulkan itself. Computing, drawing and transfers work, validation is active, and errors name the remedy.

use std::process::Command;

use leadr_gpu::{
    AddressMode, Buffer, ColorTarget, Commands, ComputePipeline, Depth, DepthTarget, Descriptor, Filter, Gpu,
    GpuOptions, GraphicsDesc, GraphicsPipeline, Image, ImageDesc, Load, Memory, Sampler, SharedStruct, SpecValue,
    Timestamps, Topology, Use, vk,
};
use leadr_testing::gpu::{Count, run_probe, run_probe_with, test_gpu};

pub(super) const FLOATS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

#[test]
fn a_probe_sees_every_item_once() {
    let Some(gpu) = test_gpu() else { return };
    // This is more than one chunk, and not a multiple of the work group size.
    let inputs: Vec<[f32; 1]> = (0..300_001).map(|i| [i as f32]).collect();
    let outputs = run_probe(&gpu, "probes/selftest/selftest.comp", &inputs, 1);
    assert_eq!(outputs.len(), inputs.len());
    assert!(outputs.iter().enumerate().all(|(i, y)| *y == 2.0 * i as f32));
}

#[test]
fn device_buffers_keep_what_is_written_in_pieces() {
    let Some(gpu) = test_gpu() else { return };
    // The data exceeds one staging chunk.
    let data: Vec<u32> = (0..10_000_000u32).map(|i| i.wrapping_mul(2_654_435_761)).collect();
    let buffer = Buffer::from_slice(&gpu, "large", &data).unwrap();
    assert!(buffer.read_all::<u32>().unwrap() == data);
    buffer.write(40, &[1u32, 2, 3]).unwrap();
    assert_eq!(buffer.read::<u32>(36, 5).unwrap(), [data[9], 1, 2, 3, data[13]]);
    let error = buffer.write(buffer.size() - 4, &[0u64]).unwrap_err().to_string();
    assert!(error.contains("large") && error.contains("more than"), "{error}");
}

leadr_gpu::shared_struct! {
    struct Item for "Item" {
        position: [f32; 3],
        weight: f32,
        frame: [[f32; 4]; 4],
        extent: [f32; 2],
        padding: [f32; 2],
    }
}

leadr_gpu::shared_struct! {
    /// The head of a buffer that ends in an array of [`Item`]s.
    struct ItemsHead for "Items" {
        items_used: u32,
        padding: [u32; 3],
    }
}

leadr_gpu::shared_struct! {
    /// In `std140`, the elements of arrays are 16 bytes apart.
    struct Settings for "Settings" {
        offset: [f32; 4],
        gain: [[f32; 4]; 3],
    }
}

#[test]
fn constants_includes_and_shared_structs() {
    let Some(gpu) = test_gpu() else { return };
    let shader = "probes/selftest/selftest_spec.comp";
    let item = |weight| Item {
        position: [0.0; 3],
        weight,
        frame: [[0.0; 4], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 4.0]],
        extent: [0.0, 0.5],
        padding: [0.0; 2],
    };
    let bytes = size_of::<ItemsHead>() + 2 * size_of::<Item>();
    let items = Buffer::new(&gpu, "items", bytes as u64, Memory::Upload).unwrap();
    items.write(0, &[ItemsHead { items_used: 1, padding: [0; 3] }]).unwrap();
    items.write(size_of::<ItemsHead>() as u64, &[item(100.0), item(2.0)]).unwrap();
    let settings = Settings { offset: [3.0, 0.0, 0.0, 0.0], gain: [[0.0; 4], [0.0; 4], [10.0; 4]] };
    let settings = Buffer::from_slice(&gpu, "settings", &[settings]).unwrap();
    let further = [("Items", Descriptor::Storage(&items)), ("Settings", Descriptor::Uniform(&settings))];
    let structs = [Item::LAYOUT, ItemsHead::LAYOUT, Settings::LAYOUT];
    let inputs = [[1.0], [2.0], [3.0]];
    let plain = run_probe_with(&gpu, shader, &inputs, 1, &[], &further, &structs);
    assert_eq!(plain, [39.5, 40.5, 41.5]);
    let spec = [
        ("SCALE", SpecValue::F32(0.5)),
        ("SHIFT", SpecValue::I32(-3)),
        ("NEGATE", SpecValue::Bool(true)),
        ("LIMIT", SpecValue::U32(2)),
    ];
    let special = run_probe_with(&gpu, shader, &inputs, 1, &spec, &further, &structs);
    assert_eq!(special[..2], [41.0, 40.5]);
    assert!(special[2].is_nan(), "LIMIT keeps the third invocation from writing");
}

/// The expected output of `selftest_branches.comp`.
#[derive(Clone, Copy, Debug)]
struct Branches {
    way: i32,
    early: bool,
    limit: f32,
    turns: u32,
    once: bool,
}

impl Branches {
    fn far(self) -> bool {
        self.limit > 2.0 || self.way == 3
    }

    fn switched(self, v: f32) -> f32 {
        let out_of_two = |v: f32| if v > 4.0 { v - 10.0 } else { v * 3.0 };
        0.5 + match self.way {
            0 => v + 1.0,
            1 => out_of_two(v + 2.0),
            2 => out_of_two(v),
            _ => return -v,
        }
    }

    fn looped(self, mut v: f32) -> f32 {
        let step = if self.way == 3 { 2 } else { self.way + 1 };
        for i in 0..self.turns {
            if self.early && i == 1 {
                return v + 100.0;
            }
            if self.way == 2 {
                continue;
            }
            if !self.far() {
                v += 3.0 * step as f32;
            }
            if v > 20.0 {
                break;
            }
        }
        v
    }

    fn at_least_once(self, mut v: f32) -> f32 {
        for _ in 0..if self.once { 1 } else { 4 } {
            v = v * 0.5 + 1.0;
        }
        while self.far() {
            v -= 3.0;
            if v < 0.0 {
                break;
            }
        }
        v
    }

    fn called(self, mut v: f32) -> f32 {
        let chosen = self.early ^ (self.way == 1);
        v += f32::from(u8::from(chosen)) + 0.5 * (self.way + 1).max(0) as f32;
        if v > 2.0 && (self.early || (chosen && self.once)) {
            v = -v;
        }
        if self.way == 1 && v > 3.0 {
            v += 8.0;
        }
        if self.way == 2 { v - 2.0 } else { v }
    }

    fn value(self, v: f32) -> f32 {
        if self.limit < 0.0 {
            return if self.early && v > 2.0 { 7.0 } else { -7.0 };
        }
        let v = self.switched(v);
        let v = match () {
            () if !self.early || v > self.limit => self.looped(v),
            () if self.turns % 2 == 1 => v + 0.25,
            () => v,
        };
        self.called(self.at_least_once(v))
    }
}

#[test]
fn constants_decide_where_shaders_go_on() {
    let Some(gpu) = test_gpu() else { return };
    let inputs: Vec<[f32; 1]> = (0..40).map(|i| [i as f32 * 0.5 - 4.0]).collect();
    let (ways, truths) = ([0, 1, 2, 3, -5], [false, true]);
    let mut seen = std::collections::BTreeSet::new();
    for (way, early, once) in ways.into_iter().flat_map(|way| truths.map(|early| (way, early, !early ^ (way == 1)))) {
        for (limit, turns) in [(-1.0, 1), (1.0, 0), (1.0, 4), (3.0, 3)] {
            let branches = Branches { way, early, limit, turns, once };
            let spec = [
                ("WAY", SpecValue::I32(way)),
                ("EARLY", SpecValue::Bool(early)),
                ("LIMIT", SpecValue::F32(limit)),
                ("TURNS", SpecValue::U32(turns)),
                ("ONCE", SpecValue::Bool(once)),
            ];
            let shader = "probes/selftest/selftest_branches.comp";
            let outputs = run_probe_with(&gpu, shader, &inputs, 1, &spec, &[], &[]);
            let expected: Vec<f32> = inputs.iter().map(|[v]| branches.value(*v)).collect();
            assert_eq!(outputs, expected, "{branches:?}");
            seen.insert(format!("{outputs:?}"));
        }
    }
    // Fewer different outputs would mean that constants have no effect.
    assert!(seen.len() > 20, "{} different outputs", seen.len());
}

/// A colour that differs by mip, layer and position.
fn texels(size: u32, mip: u32, layer: u32) -> Vec<[f32; 4]> {
    (0..size * size).map(|i| [mip as f32, layer as f32, i as f32, 1.0]).collect()
}

#[test]
fn images_keep_every_mip_of_every_layer() {
    let Some(gpu) = test_gpu() else { return };
    let image = Image::new(&gpu, "array", ImageDesc::new(FLOATS, 16, 16).full_mips().layers(3)).unwrap();
    assert_eq!(image.desc().mips, 5);
    for (mip, layer) in (0..5).flat_map(|mip| (0..3).map(move |layer| (mip, layer))) {
        image.write(mip, layer, &texels(16 >> mip, mip, layer)).unwrap();
    }
    for (mip, layer) in (0..5).flat_map(|mip| (0..3).map(move |layer| (mip, layer))) {
        assert_eq!(image.read::<[f32; 4]>(mip, layer).unwrap(), texels(16 >> mip, mip, layer));
    }
    for (error, words) in [
        (image.write(5, 0, &texels(1, 0, 0)).unwrap_err(), "mip 5"),
        (image.write(0, 3, &texels(16, 0, 0)).unwrap_err(), "layer 3"),
        (image.write(1, 0, &texels(16, 0, 0)).unwrap_err(), "8x8"),
        (Image::new(&gpu, "odd", ImageDesc::new(FLOATS, 4, 5).cube()).map(drop).unwrap_err(), "square"),
        (Image::new(&gpu, "none", ImageDesc::new(FLOATS, 0, 5)).map(drop).unwrap_err(), "0x5"),
        (Image::new(&gpu, "wide", ImageDesc::new(FLOATS, 1 << 24, 1)).map(drop).unwrap_err(), "16777216x1"),
    ] {
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn large_images_pass_through_in_chunks() {
    let Some(gpu) = test_gpu() else { return };
    let (width, height) = (1024, 2100);
    let image = Image::new(&gpu, "atlas", ImageDesc::new(FLOATS, width, height)).unwrap();
    let data: Vec<[f32; 4]> = (0..width * height).map(|i| [i as f32, 0.5, -1.0, 0.0]).collect();
    image.write(0, 0, &data).unwrap();
    assert!(image.read::<[f32; 4]>(0, 0).unwrap() == data);
}

#[test]
fn cubes_have_their_faces_where_vulkan_puts_them() {
    let Some(gpu) = test_gpu() else { return };
    let cube = Image::new(&gpu, "cube", ImageDesc::new(FLOATS, 8, 8).cube().mips(2)).unwrap();
    for face in 0..6 {
        cube.write(0, face, &vec![[face as f32, 0.0, 0.0, 1.0]; 64]).unwrap();
        cube.write(1, face, &vec![[face as f32 + 10.0, 0.0, 0.0, 1.0]; 16]).unwrap();
    }
    let sampler = Sampler::new(&gpu, Filter::Trilinear, AddressMode::ClampToEdge).unwrap();
    let axes =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    for (lod, added) in [(0.0, 0.0), (1.0, 10.0), (0.5, 5.0)] {
        let inputs = axes.map(|[x, y, z]| [x, y, z, lod]);
        let further = [("cube", Descriptor::Sampled(cube.whole(), &sampler))];
        let outputs = run_probe_with(&gpu, "probes/selftest/selftest_cube.comp", &inputs, 4, &[], &further, &[]);
        let faces: Vec<f32> = outputs.chunks(4).map(|color| color[0] - added).collect();
        assert_eq!(faces, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0], "lod {lod}");
    }
}

#[test]
fn a_compute_mip_chain_with_barriers_by_mip() {
    let Some(gpu) = test_gpu() else { return };
    let desc = ImageDesc::new(FLOATS, 8, 8).full_mips().layers(2).storage();
    let image = Image::new(&gpu, "chain", desc).unwrap();
    for layer in 0..2 {
        let data: Vec<[f32; 4]> = (0..64).map(|i| [i as f32, layer as f32, 0.0, 1.0]).collect();
        image.write(0, layer, &data).unwrap();
    }
    let half = ComputePipeline::new(&gpu, "probes/selftest/selftest_half.comp", &[], &[]).unwrap();
    assert_eq!(half.local_size(), [8, 8, 1]);
    let views: Vec<_> = (0..4).map(|mip| image.mip_array(mip).unwrap()).collect();
    gpu.submit("mips", |cmd| {
        cmd.transition(&image, Use::ComputeReadWrite);
        for mip in 1..4u32 {
            let [from, to] = [&views[mip as usize - 1], &views[mip as usize]];
            cmd.bind(&half, &[("source", Descriptor::StorageImage(from)), ("target", Descriptor::StorageImage(to))]);
            let [width, height] = to.extent();
            cmd.dispatch_invocations(&half, [width, height, 2]);
            cmd.mip_barrier(&image, mip..mip + 1, 0..2, Use::ComputeWrite, Use::ComputeRead);
        }
        cmd.transition(&image, Use::Sampled);
    })
    .unwrap();
    for layer in 0..2 {
        assert_eq!(image.read::<[f32; 4]>(3, layer).unwrap(), [[31.5, layer as f32, 0.0, 1.0]]);
    }
}

const CORNERS: [[f32; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];

leadr_gpu::shared_struct! {
    pub(super) struct Push for "P" {
        color: [f32; 4],
        depth: f32,
        padding: [f32; 3],
    }
}

fn push(red: f32, depth: f32) -> Push {
    Push { color: [red, 0.0, 0.0, 1.0], depth, padding: [0.0; 3] }
}

struct Target {
    color: Image,
    depth: Image,
}

impl Target {
    fn new(gpu: &std::sync::Arc<Gpu>, size: u32) -> Self {
        let color = Image::new(gpu, "color", ImageDesc::new(FLOATS, size, size).color_target()).unwrap();
        let desc = ImageDesc::new(vk::Format::D32_SFLOAT, size, size).depth_target();
        Self { color, depth: Image::new(gpu, "depth", desc).unwrap() }
    }

    fn begin(&self, cmd: &mut Commands) {
        cmd.transition(&self.color, Use::ColorTarget);
        cmd.transition(&self.depth, Use::DepthTarget);
        cmd.begin_rendering(
            &[ColorTarget { view: self.color.whole(), load: Load::Clear([-1.0; 4]) }],
            Some(DepthTarget { view: self.depth.whole(), clear: Some(0.0) }),
        );
    }
}

#[test]
fn a_tessellated_quad_fills_its_pixels_and_depth() {
    let Some(gpu) = test_gpu() else { return };
    let corners = Buffer::from_slice(&gpu, "corners", &CORNERS).unwrap();
    let target = Target::new(&gpu, 64);
    let desc = GraphicsDesc {
        vertex: "probes/selftest/selftest.vert",
        tessellation: Some(["probes/selftest/selftest.tesc", "probes/selftest/selftest.tese"]),
        fragment: Some("probes/selftest/selftest_uv.frag"),
        colors: &[FLOATS],
        depth: Some(Depth::default()),
        topology: Topology::Patches(4),
        spec: &[("LEVEL", SpecValue::F32(7.0))],
        structs: &[Push::LAYOUT],
        ..Default::default()
    };
    let pipeline = GraphicsPipeline::new(&gpu, "quad", &desc).unwrap();
    gpu.submit("quad", |cmd| {
        target.begin(cmd);
        cmd.bind(&pipeline, &[("Corners", Descriptor::Storage(&corners))]);
        cmd.push_constants(&push(0.0, 0.25));
        cmd.draw(0..4, 0..1);
        cmd.end_rendering();
    })
    .unwrap();
    let pixels = target.color.read::<[f32; 4]>(0, 0).unwrap();
    let depths = target.depth.read::<f32>(0, 0).unwrap();
    for (i, (pixel, depth)) in pixels.iter().zip(&depths).enumerate() {
        let [x, y] = [i % 64, i / 64];
        if (16..48).contains(&x) && (16..48).contains(&y) {
            let expected = [x, y].map(|at| (at as f32 + 0.5 - 16.0) / 32.0);
            assert!(
                (pixel[0] - expected[0]).abs() < 1e-4 && (pixel[1] - expected[1]).abs() < 1e-4,
                "{x} {y} {pixel:?}"
            );
            assert_eq!((pixel[2], *depth), (0.25, 0.25));
        } else {
            assert_eq!((*pixel, *depth), ([-1.0; 4], 0.0), "{x} {y}");
        }
    }
}

#[test]
fn reversed_depth_lets_the_nearer_pass_in_any_order() {
    let Some(gpu) = test_gpu() else { return };
    let triangle = Buffer::from_slice(&gpu, "corners", &[[-1.0f32, -1.0], [3.0, -1.0], [-1.0, 3.0]]).unwrap();
    let target = Target::new(&gpu, 32);
    let desc = GraphicsDesc {
        vertex: "probes/selftest/selftest.vert",
        fragment: Some("probes/selftest/selftest.frag"),
        colors: &[FLOATS],
        depth: Some(Depth::default()),
        structs: &[Push::LAYOUT],
        ..Default::default()
    };
    let pipeline = GraphicsPipeline::new(&gpu, "triangles", &desc).unwrap();
    let center = |order: [Push; 2]| {
        gpu.submit("triangles", |cmd| {
            target.begin(cmd);
            cmd.bind(&pipeline, &[("Corners", Descriptor::Storage(&triangle))]);
            for constants in order {
                cmd.push_constants(&constants);
                cmd.draw(0..3, 0..1);
            }
            cmd.end_rendering();
        })
        .unwrap();
        target.color.read::<[f32; 4]>(0, 0).unwrap()[16 * 32 + 16][0]
    };
    let [near, far] = [push(1.0, 0.75), push(2.0, 0.5)];
    assert_eq!(center([near, far]), 1.0);
    assert_eq!(center([far, near]), 1.0);
}

#[test]
fn timestamps_rise_and_carry_their_names() {
    let Some(gpu) = test_gpu() else { return };
    let timestamps = Timestamps::new(&gpu, 3).unwrap();
    let buffer = Buffer::new(&gpu, "filled", 64 << 20, Memory::Device).unwrap();
    gpu.submit("timed", |cmd| {
        cmd.reset_timestamps(&timestamps);
        cmd.timestamp(&timestamps, "start");
        cmd.fill_buffer(&buffer, 1);
        cmd.full_barrier();
        cmd.timestamp(&timestamps, "long");
        cmd.timestamp(&timestamps, "nothing");
    })
    .unwrap();
    let marks = timestamps.marks().unwrap();
    assert!(marks.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{marks:?}");
    let intervals = timestamps.intervals().unwrap();
    let names: Vec<&str> = intervals.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["long", "nothing"]);
    assert!(intervals[0].1 > 0.01 && intervals[0].1 > intervals[1].1, "{intervals:?}");
    let error = gpu
        .submit("too many", |cmd| {
            cmd.reset_timestamps(&timestamps);
            (0..4).for_each(|_| cmd.timestamp(&timestamps, "mark"));
        })
        .unwrap_err();
    assert!(error.to_string().contains("room for only 3"), "{error}");
}

#[test]
fn validation_reports_a_wrong_layout() {
    let Some(gpu) = test_gpu() else { return };
    let cube = Image::new(&gpu, "cube", ImageDesc::new(FLOATS, 8, 8).cube()).unwrap();
    let sampler = Sampler::new(&gpu, Filter::Nearest, AddressMode::ClampToEdge).unwrap();
    // The cube is never written and never changed to Use::Sampled.
    let further = [("cube", Descriptor::Sampled(cube.whole(), &sampler))];
    run_probe_with(&gpu, "probes/selftest/selftest_cube.comp", &[[1.0, 0.0, 0.0, 0.0]], 4, &[], &further, &[]);
    let messages = gpu.take_validation_messages();
    assert!(messages.iter().any(|message| message.contains("layout")), "{messages:?}");
}

#[test]
fn validation_reports_a_missing_barrier() {
    let Some(gpu) = test_gpu() else { return };
    let double = ComputePipeline::new(&gpu, "probes/selftest/selftest.comp", &[], &[Count::LAYOUT]).unwrap();
    let [a, b, c] = ["a", "b", "c"].map(|name| Buffer::from_slice(&gpu, name, &[1.0f32; 64]).unwrap());
    let run = |barrier: bool| {
        gpu.submit("twice", |cmd| {
            for (i, [from, to]) in [[&a, &b], [&b, &c]].into_iter().enumerate() {
                if i == 1 && barrier {
                    cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
                }
                cmd.bind(&double, &[("In", Descriptor::Storage(from)), ("Out", Descriptor::Storage(to))]);
                cmd.push_constants(&Count { count: 64 });
                cmd.dispatch([1, 1, 1]);
            }
        })
        .unwrap();
    };
    run(true);
    gpu.assert_silent();
    assert_eq!(c.read_all::<f32>().unwrap(), [4.0; 64]);
    run(false);
    let messages = gpu.take_validation_messages();
    assert!(messages.iter().any(|message| message.to_lowercase().contains("hazard")), "{messages:?}");
}

#[test]
fn the_guard_fails_a_test_that_validation_complains_about() {
    let Some(gpu) = test_gpu() else { return };
    let cube = Image::new(&gpu, "cube", ImageDesc::new(FLOATS, 8, 8).cube()).unwrap();
    let sampler = Sampler::new(&gpu, Filter::Nearest, AddressMode::ClampToEdge).unwrap();
    let further = [("cube", Descriptor::Sampled(cube.whole(), &sampler))];
    run_probe_with(&gpu, "probes/selftest/selftest_cube.comp", &[[1.0, 0.0, 0.0, 0.0]], 4, &[], &further, &[]);
    let failure = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || drop(gpu))).unwrap_err();
    let text = failure.downcast_ref::<String>().unwrap();
    assert!(text.contains("validation on"), "{text}");
}

#[test]
fn unknown_device_lists_available_devices() {
    let Some(gpu) = test_gpu() else { return };
    for wanted in ["no such device", "99", ""] {
        let options = GpuOptions { device: Some(wanted.to_owned()), ..Default::default() };
        let error = Gpu::new(&options).map(drop).unwrap_err().to_string();
        assert!(error.contains(gpu.device_name()) && error.contains("0: "), "{error}");
    }
    let part = gpu.device_name()[..4].to_uppercase();
    let found = Gpu::new(&GpuOptions { device: Some(part), ..Default::default() }).unwrap();
    assert_eq!(found.device_name()[..4], gpu.device_name()[..4]);
}

#[test]
fn missing_driver_error_gives_install_hint() {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "device::child_without_a_driver", "--nocapture"])
        .env("VK_DRIVER_FILES", "nonexistent.json")
        .env("VK_ICD_FILENAMES", "nonexistent.json")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&child.stdout);
    assert!(child.status.success(), "{text}{}", String::from_utf8_lossy(&child.stderr));
    assert!(text.contains("install") && text.contains("mesa-vulkan-drivers"), "{text}");
}

/// Tests an atlas as large as the baked one, with half a gigabyte through a 2 GiB heap. Run it by hand.
#[test]
#[ignore = "needs 1.5 GiB of memory"]
fn the_largest_atlas_passes_through() {
    let Some(gpu) = test_gpu() else { return };
    let image = Image::new(&gpu, "atlas", ImageDesc::new(FLOATS, 4096, 5696).full_mips().storage()).unwrap();
    let data: Vec<[f32; 4]> = (0..4096 * 5696).map(|i| [i as f32, 0.5, -1.0, 0.0]).collect();
    image.write(0, 0, &data).unwrap();
    assert!(image.read::<[f32; 4]>(0, 0).unwrap() == data);
}

/// `missing_driver_error_gives_install_hint` runs this test in another process, because the loader reads its variables once.
#[test]
fn child_without_a_driver() {
    if std::env::var_os("VK_DRIVER_FILES").is_none_or(|files| files != "nonexistent.json") {
        return;
    }
    let error = Gpu::new(&GpuOptions::default()).map(drop).unwrap_err();
    println!("{error}");
}

/// The objects of a large scene have a few samplers each, and some devices support only 4,000 samplers.
#[test]
fn samplers_of_a_kind_are_one() {
    let Some(gpu) = test_gpu() else { return };
    let sampler = |filter, mode| Sampler::new(&gpu, filter, mode).unwrap();
    let many: Vec<Sampler> = (0..5000).map(|_| sampler(Filter::Trilinear, AddressMode::Repeat)).collect();
    assert!(many.iter().all(|other| other.raw() == many[0].raw()));
    let others = [(Filter::Bilinear, AddressMode::Repeat), (Filter::Trilinear, AddressMode::Mirror)];
    for other in others.map(|(filter, mode)| sampler(filter, mode)) {
        assert_ne!(other.raw(), many[0].raw());
    }
    drop(many);
    assert_ne!(sampler(Filter::Trilinear, AddressMode::Repeat).raw(), vk::Sampler::null());
}
