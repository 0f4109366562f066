//! Unreasonable arguments, for which results must still be finite.

use glam::DVec3;
use leadr_testing::gpu::{TestGpu, run_probe};

use super::comparator::{Arguments as _, TUPLES};
use leadr_reflectance::random::Random;

fn number(r: &mut Random) -> f32 {
    r.pick([0.0, 1e-30, -1e-30, 1e-12, 1.0, -1.0, 0.5, 1e3, -1e3, 1e6, -1e6]) as f32
}

fn direction(r: &mut Random) -> [f32; 3] {
    let v = DVec3::new(r.pick([0.0, 1.0, -1.0, 1e-7]), r.pick([0.0, 1.0, -1e-4]), r.pick([0.0, 1.0, -1.0, 1e-20]));
    v.try_normalize().unwrap_or(DVec3::NEG_Z).to_array().map(|v| v as f32)
}

/// Runs a probe on unit directions along and close to the axes, followed by extreme numbers and the values of `tail`.
pub fn finite<const N: usize, const TAIL: usize>(
    gpu: &TestGpu,
    r: &mut Random,
    name: &str,
    outputs: usize,
    directions: usize,
    tail: impl Fn(&mut Random) -> [f32; TAIL],
) {
    let items: Vec<[f32; N]> = (0..TUPLES)
        .map(|_| {
            let mut x: Vec<f32> = (0..directions).flat_map(|_| direction(r)).collect();
            x.resize_with(N - TAIL, || number(r));
            x.extend(tail(r));
            x.try_into().expect("as many as the probe reads")
        })
        .collect();
    let got = run_probe::<N>(gpu, &format!("probes/{name}.comp"), &items, outputs);
    assert_eq!(got.len(), items.len() * outputs);
    let bad: Vec<_> = got.iter().enumerate().filter(|(_, v)| !v.is_finite()).map(|(i, _)| i).collect();
    assert!(
        bad.is_empty(),
        "{name} on {}: {} values not finite, first output {} of {:?}",
        gpu.device_name(),
        bad.len(),
        bad[0] % outputs,
        items[bad[0] / outputs]
    );
}
