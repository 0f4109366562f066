//! Random arguments, and the comparison of a probe's results with the f64 reference.

use glam::{DVec2, DVec3};
use leadr_gpu::{Buffer, Descriptor};
use leadr_reflectance::random::Random;
use leadr_testing::gpu::{run_probe_with, test_gpu};

/// Arguments per probe.
pub const TUPLES: usize = 100_000;

/// Number of arguments to test the comparison with a reference that is one percent off.
const PERTURBED: usize = 10_000;

/// One in this many arguments is examined for the share of well-conditioned values.
const SAMPLED: usize = 16;

/// Two arguments from index `at` as a vector.
pub fn v2(x: &[f64], at: usize) -> DVec2 {
    DVec2::new(x[at], x[at + 1])
}

/// Three arguments from index `at` as a vector.
pub fn v3(x: &[f64], at: usize) -> DVec3 {
    DVec3::new(x[at], x[at + 1], x[at + 2])
}

/// The arguments of one tuple, concatenated from parts.
pub fn join<const N: usize>(parts: &[&[f64]]) -> [f64; N] {
    parts.concat().try_into().unwrap_or_else(|v: Vec<f64>| panic!("{} values instead of {N}", v.len()))
}

/// Random arguments, including unusual ones.
pub trait Arguments {
    fn pick<const N: usize>(&mut self, values: [f64; N]) -> f64;

    /// A direction anywhere on the sphere, near the horizon, near the pole, or on an axis.
    fn direction(&mut self) -> DVec3;

    fn mean_slope(&mut self) -> DVec2;

    /// A covariance of common roughness; a quarter are degenerate: zero, rank one, extremely anisotropic, out of bounds.
    fn covariance(&mut self) -> DVec3;
}

impl Arguments for Random {
    fn pick<const N: usize>(&mut self, values: [f64; N]) -> f64 {
        values[(self.unit() * N as f64) as usize]
    }

    fn direction(&mut self) -> DVec3 {
        let phi = self.range(0.0, std::f64::consts::TAU);
        let z = match (self.unit() * 10.0) as u32 {
            0 => return DVec3::Z,
            1 => return DVec3::new(self.pick([1.0, -1.0]), 0.0, 0.0),
            2 => self.pick([1.0, -1.0]) * self.log(1e-7, 1e-2),
            3 => 1.0 - self.log(1e-7, 1e-2),
            4 => self.range(-1.0, 0.0),
            _ => self.range(0.0, 1.0),
        };
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z).normalize()
    }

    fn mean_slope(&mut self) -> DVec2 {
        match (self.unit() * 4.0) as u32 {
            0 => DVec2::ZERO,
            1 => DVec2::new(self.range(-8.0, 8.0), self.range(-8.0, 8.0)),
            _ => DVec2::new(self.range(-0.7, 0.7), self.range(-0.7, 0.7)),
        }
    }

    fn covariance(&mut self) -> DVec3 {
        let (x, y) = (self.log(0.02, 2.0), self.log(0.02, 2.0));
        let r = self.range(-0.95, 0.95);
        match (self.unit() * 20.0) as u32 {
            0 => DVec3::ZERO,
            1 => DVec3::new(x * x, 0.0, 0.0),
            2 => DVec3::new(1e-12, y * y, x),
            3 => DVec3::new(x * x, y * y, self.pick([1.0, -1.0]) * x * y),
            4 => DVec3::new(x * 1e-4, y * 1e-4, r * 1e-4 * (x * y).sqrt()),
            _ => DVec3::new(x * x, y * y, r * x * y),
        }
    }
}

/// Accuracy required of one probe.
pub struct Tolerance {
    /// Error allowed relative to `max(|reference|, floor)`.
    pub relative: f64,
    /// Magnitude below which errors are absolute, by the index of the output: the size of the terms in its sum.
    pub floor: fn(usize) -> f64,
    /// Smaller arguments are shifted as if they had this magnitude, by the index of the argument: 4 for an angle whose sine a
    /// device computes to a few ten-millionths.
    pub unit: fn(usize) -> f64,
}

/// Outcome of a comparison: the worst relative error among well-conditioned values, and the failures.
struct Outcome {
    worst: f64,
    worst_at: String,
    well_conditioned: usize,
    sampled: usize,
    values: usize,
    /// Values beyond the tolerance.
    failures: usize,
    /// Failures beyond the outliers' tolerance.
    gross: usize,
    first: String,
}

impl Outcome {
    fn fails(&self) -> bool {
        self.gross > 0 || self.failures * OUTLIERS > self.values
    }
}

/// Relative shift of an argument; the resulting change of the reference, times [`SPREADS`], is tolerated.
const NUDGE: f64 = 1.2e-7;
/// Divisions and roots err by 2.5 units in the last place at Vulkan's bound, and by half a unit on lavapipe.
const SPREADS: f64 = 8.0;

/// One in this many values may err by up to [`OUTLIER`] of itself. A device that fuses multiplications with additions leaves
/// rounding errors where a difference should vanish, which show in functions of that difference alone (measured: 6 of
/// 1,200,000).
const OUTLIERS: usize = 100_000;
const OUTLIER: f64 = 1e-3;

fn compare<const N: usize>(
    inputs: &[[f32; N]],
    got: &[f32],
    tolerance: &Tolerance,
    reference: &dyn Fn(&[f64; N]) -> Vec<f64>,
) -> Outcome {
    let mut outcome = Outcome {
        worst: 0.0,
        worst_at: String::new(),
        well_conditioned: 0,
        sampled: 0,
        values: 0,
        failures: 0,
        gross: 0,
        first: String::new(),
    };
    for (i, input) in inputs.iter().enumerate() {
        let exact = input.map(f64::from);
        let want = reference(&exact);
        let outputs = want.len();
        // The change of each output is computed only where it matters.
        let spreads = std::cell::OnceCell::new();
        let spread = |k: usize| spreads.get_or_init(|| spreads_of(&exact, &want, tolerance, reference))[k];
        for (k, &want) in want.iter().enumerate() {
            let got = f64::from(got[i * outputs + k]);
            let scale = want.abs().max((tolerance.floor)(k));
            let error = (got - want).abs();
            // Subnormal numbers may be flushed to 0.
            let allowed = tolerance.relative * scale + f64::from(f32::MIN_POSITIVE);
            outcome.values += 1;
            if !got.is_finite() || error.is_nan() || (error > allowed && error > allowed + SPREADS * spread(k)) {
                outcome.failures += 1;
                outcome.gross += usize::from(!got.is_finite() || error > OUTLIER * scale + SPREADS * spread(k));
                if outcome.failures <= 5 {
                    outcome.first +=
                        &format!("\n  output {k} of {input:?}: {got:e} instead of {want:e} (spread {:.1e})", spread(k));
                }
            }
            // Well conditioned: rounding the arguments changes the value by less than the tolerance.
            if i % SAMPLED == 0 {
                outcome.sampled += 1;
                outcome.well_conditioned += usize::from(SPREADS * spread(k) <= allowed);
            }
            if error / scale > outcome.worst && SPREADS * spread(k) <= allowed {
                outcome.worst = error / scale;
                outcome.worst_at = format!("output {k} of {input:?}");
            }
        }
    }
    outcome
}

/// Total change of every output when each argument is shifted by a rounding error, one at a time.
fn spreads_of<const N: usize>(
    exact: &[f64; N],
    want: &[f64],
    tolerance: &Tolerance,
    reference: &dyn Fn(&[f64; N]) -> Vec<f64>,
) -> Vec<f64> {
    let mut spread = vec![0.0; want.len()];
    for (k, value) in exact.iter().enumerate() {
        for sign in [-1.0, 1.0] {
            let mut moved = *exact;
            moved[k] = value + sign * NUDGE * value.abs().max((tolerance.unit)(k)).max(1e-30);
            for (s, (a, b)) in spread.iter_mut().zip(reference(&moved).iter().zip(want)) {
                *s += (a - b).abs();
            }
        }
    }
    spread
}

/// Runs a probe on [`TUPLES`] arguments and compares its results with `reference`. The comparison must fail when the
/// reference is one percent off.
pub fn parity<const N: usize>(
    name: &str,
    tolerance: Tolerance,
    tuple: impl FnMut(&mut Random) -> [f64; N],
    reference: impl Fn(&[f64; N]) -> Vec<f64>,
) {
    parity_with(name, tolerance, None, tuple, reference);
}

/// The same for a probe that also reads a buffer of this name.
pub fn parity_with<const N: usize>(
    name: &str,
    tolerance: Tolerance,
    table: Option<(&str, &[f32])>,
    mut tuple: impl FnMut(&mut Random) -> [f64; N],
    reference: impl Fn(&[f64; N]) -> Vec<f64>,
) {
    let Some(gpu) = test_gpu() else { return };
    let table = table.map(|(block, words)| (block, Buffer::from_slice(&gpu, block, words).unwrap()));
    let further: Vec<_> = table.iter().map(|(block, buffer)| (*block, Descriptor::Storage(buffer))).collect();
    let mut random = Random(0x1ead);
    let inputs: Vec<[f32; N]> = (0..TUPLES).map(|_| tuple(&mut random).map(|v| v as f32)).collect();
    let outputs = reference(&inputs[0].map(f64::from)).len();
    let got = run_probe_with(&gpu, &format!("probes/{name}.comp"), &inputs, outputs, &[], &further, &[]);
    let outcome = compare(&inputs, &got, &tolerance, &reference);
    println!(
        "{name}: {TUPLES} tuples, {:.1} % of values well conditioned, their worst relative error {:.1e} ({})",
        100.0 * outcome.well_conditioned as f64 / outcome.sampled as f64,
        outcome.worst,
        outcome.worst_at
    );
    assert!(
        !outcome.fails(),
        "{name} on {}: {} values beyond {:.0e}:{}",
        gpu.device_name(),
        outcome.failures,
        tolerance.relative,
        outcome.first
    );
    // A comparison that is too tolerant would also accept one percent more on every reference value.
    let off = |input: &[f64; N]| reference(input).iter().map(|v| v * 1.01).collect();
    let perturbed = compare(&inputs[..PERTURBED], &got, &tolerance, &off);
    assert!(perturbed.failures > PERTURBED / 2, "{name}: one percent off fails only {} times", perturbed.failures);
}

/// Parts of a list.
pub trait Numbers {
    fn numbers(self) -> Vec<f64>;
}

impl Numbers for DVec2 {
    fn numbers(self) -> Vec<f64> {
        self.to_array().to_vec()
    }
}

impl Numbers for DVec3 {
    fn numbers(self) -> Vec<f64> {
        self.to_array().to_vec()
    }
}

impl<const N: usize> Numbers for [f64; N] {
    fn numbers(self) -> Vec<f64> {
        self.to_vec()
    }
}

/// Flattens vectors and numbers into one list.
macro_rules! list {
    ($($part:expr),* $(,)?) => {{
        let mut all = Vec::new();
        $(all.extend(Numbers::numbers($part));)*
        all
    }};
}

pub(crate) use list;
