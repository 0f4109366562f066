//! Tests how longer-lived sets are bound, how long they live, and which are rejected.

use std::sync::Arc;

use leadr_gpu::shaders::ResourceKind::{Sampled, Storage, Uniform};
use leadr_gpu::{
    Buffer, Commands, ComputePipeline, Descriptor, Gpu, GpuOptions, Memory, ResourceSet, SetLayout, SharedStruct,
};
use leadr_testing::gpu::{Count, test_gpu};

const SHADER: &str = "probes/selftest/selftest_sets.comp";

// Each unused resource comes first, so that the binding numbers matter.
static FACTORS: SetLayout =
    SetLayout { number: 1, name: "scene", resources: &[("Unread", Uniform), ("Factors", Storage)] };
static TERMS: SetLayout = SetLayout { number: 2, name: "object", resources: &[("Terms", Storage)] };
static TEXTURES: SetLayout = SetLayout { number: 2, name: "texture", resources: &[("Terms", Sampled)] };
static OTHER_TERMS: SetLayout = SetLayout { number: 2, name: "stranger", resources: &[("Terms", Storage)] };

/// Opens a device with these sets. Returns `None` if tests run without a device.
fn gpu_with(sets: &[&'static SetLayout]) -> Option<Arc<Gpu>> {
    test_gpu()?;
    let options = GpuOptions {
        device: std::env::var("LEADR_DEVICE").ok(),
        validation: true,
        shaders: vec![leadr_probes::PROBES],
        sets: sets.to_vec(),
        ..Default::default()
    };
    Some(Gpu::new(&options).unwrap())
}

fn buffer(gpu: &Arc<Gpu>, value: f32) -> Buffer {
    Buffer::from_slice(gpu, "value", &[value]).unwrap()
}

fn factors(gpu: &Arc<Gpu>, value: f32) -> ResourceSet {
    let buffer = buffer(gpu, value);
    let resources = [("Factors", Descriptor::Storage(&buffer)), ("Unread", Descriptor::Uniform(&buffer))];
    ResourceSet::new(gpu, &FACTORS, &resources).unwrap()
}

fn terms(gpu: &Arc<Gpu>, value: f32) -> ResourceSet {
    ResourceSet::new(gpu, &TERMS, &[("Terms", Descriptor::Storage(&buffer(gpu, value)))]).unwrap()
}

struct Probe {
    pipeline: ComputePipeline,
    input: Buffer,
    output: Buffer,
}

impl Probe {
    fn new(gpu: &Arc<Gpu>) -> Self {
        Self {
            pipeline: ComputePipeline::new(gpu, SHADER, &[], &[Count::LAYOUT]).unwrap(),
            input: buffer(gpu, 10.0),
            output: Buffer::new(gpu, "output", 4, Memory::Device).unwrap(),
        }
    }

    fn bind(&self, cmd: &mut Commands) {
        let [input, output] = [("In", &self.input), ("Out", &self.output)].map(|(n, b)| (n, Descriptor::Storage(b)));
        cmd.bind(&self.pipeline, &[input, output]);
    }

    fn run(&self, cmd: &mut Commands, sets: &[&ResourceSet]) {
        self.bind(cmd);
        sets.iter().for_each(|set| cmd.bind_set(set));
        cmd.push_constants(&Count { count: 1 });
        cmd.dispatch([1, 1, 1]);
    }

    fn result(&self) -> f32 {
        self.output.read_all::<f32>().unwrap()[0]
    }
}

/// There are more sets than one pool holds. Each set keeps its resources alive, and is freed when dropped.
#[test]
fn sets_are_read_by_every_pipeline_and_keep_their_resources() {
    let Some(gpu) = gpu_with(&[&FACTORS, &TERMS]) else { return };
    let (probe, factors) = (Probe::new(&gpu), factors(&gpu, 2.0));
    let all: Vec<ResourceSet> = (0..150u8).map(|i| terms(&gpu, f32::from(i))).collect();
    for i in [0, 63, 64, 149] {
        gpu.submit("sets", |cmd| probe.run(cmd, &[&factors, &all[i]])).unwrap();
        assert_eq!(probe.result(), 20.0 + i as f32);
    }
    drop(all);
    // This uses another pipeline, and a set that is dropped while it is recorded.
    gpu.submit("again", |cmd| Probe::new(&gpu).run(cmd, &[&factors, &terms(&gpu, 5.0)])).unwrap();
    gpu.submit("in any order", |cmd| probe.run(cmd, &[&terms(&gpu, 7.0), &factors])).unwrap();
    assert_eq!(probe.result(), 27.0);
    // Rebinding the pipeline drops its sets, and rebinding a set replaces it.
    gpu.submit("twice", |cmd| {
        probe.run(cmd, &[&factors, &terms(&gpu, 1.0)]);
        cmd.bind_set(&terms(&gpu, 2.0));
        cmd.dispatch([1, 1, 1]);
    })
    .unwrap();
    assert_eq!(probe.result(), 22.0);
    assert!(gpu.validation_messages().is_empty(), "{:?}", gpu.validation_messages());
}

#[test]
fn sets_that_do_not_fit_are_refused_by_name() {
    let Some(gpu) = gpu_with(&[&FACTORS, &TERMS]) else { return };
    let value = buffer(&gpu, 1.0);
    let (storage, uniform) = (Descriptor::Storage(&value), Descriptor::Uniform(&value));
    let refused = |resources: &[(&str, Descriptor<'_>)], words: &str| {
        let error = ResourceSet::new(&gpu, &FACTORS, resources).map(drop).unwrap_err().to_string();
        assert!(error.contains(words), "{error}: not {words}");
    };
    refused(&[("Factors", storage)], "Unread (a uniform buffer) was not given");
    refused(&[("Factors", uniform), ("Unread", uniform)], "Factors is a storage buffer, not a uniform buffer");
    refused(&[("Factors", storage), ("Factors", storage), ("Unread", uniform)], "Factors was given twice");
    refused(&[("Factor", storage)], "its set has no resource Factor");

    let (probe, factors, terms) = (Probe::new(&gpu), factors(&gpu, 2.0), terms(&gpu, 3.0));
    let stranger = ResourceSet::new(&gpu, &OTHER_TERMS, &[("Terms", storage)]).unwrap();
    let misused = |record: &dyn Fn(&mut Commands), words: &str| {
        let error = gpu.submit("misuse", record).unwrap_err().to_string();
        assert!(error.contains(words), "{error}: not {words}");
    };
    misused(&|cmd| probe.run(cmd, &[&factors]), "the set object was not bound");
    misused(&|cmd| probe.run(cmd, &[&factors, &stranger]), "its set 2 is object, not stranger");
    misused(&|cmd| cmd.bind_set(&terms), "before a pipeline was bound");
    misused(
        &|cmd| {
            probe.run(cmd, &[&factors, &terms]);
            probe.bind(cmd);
            cmd.dispatch([1, 1, 1]);
        },
        "the set scene was not bound",
    );
}

#[test]
fn pipelines_need_layouts_for_their_resources() {
    let fault = |sets: &[&'static SetLayout]| {
        let gpu = gpu_with(sets)?;
        Some(ComputePipeline::new(&gpu, SHADER, &[], &[Count::LAYOUT]).map(drop).unwrap_err().to_string())
    };
    for sets in [&[&FACTORS][..], &[&FACTORS, &TEXTURES]] {
        let Some(error) = fault(sets) else { return };
        assert!(error.contains("Terms is a storage buffer of set 2"), "{error}");
    }
}
