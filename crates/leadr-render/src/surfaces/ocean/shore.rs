//! A beach of the sea, with the coast along y and land toward +x. The shader code is `passes/ocean/shore.glsl`. Parity tests
//! compare [`Shore::offshore`] and [`Shore::ground`] with their GLSL versions.

use glam::{DVec2, Vec3};
use leadr_gpu::shared_struct;

use super::waves::PERIOD;

/// A sinusoidal bend of the waterline, by `amplitude · sin(step · along + phase)` metres toward the sea.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Amplitude in metres.
    pub amplitude: f64,
    /// Wave number along the coast in rad/m.
    pub step: f64,
    /// Phase in radians.
    pub phase: f64,
}

/// A beach and the swell on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shore {
    /// Slope of the sand at the rest waterline; greater than 0.
    pub slope: f64,
    /// Height of the flat sand behind the beach above the water, in metres; greater than 0.
    pub berm: f64,
    /// Distance in metres over which the sea floor levels off. The depth is proportional to `(s + reach)^⅔ − reach^⅔` (Dean's
    /// equilibrium profile, shifted for a finite slope at the waterline).
    pub reach: f64,
    /// Bends of the waterline about x = 0.
    pub bends: [Bend; 4],
    /// Number of swell waves per [`PERIOD`]; greater than 0.
    pub swells: u32,
    /// Run-up height of the highest waves above the rest level, in metres.
    pub run_up: f64,
    /// Linear albedo of wet sand.
    pub bed: Vec3,
    /// Extinction of light in the water, per metre.
    pub extinction: Vec3,
}

impl Shore {
    /// Returns the distance from the waterline in metres, positive toward the sea.
    pub fn offshore(&self, point: DVec2) -> f64 {
        -point.x - self.waterline(-point.y)
    }

    /// Returns −x of the rest waterline at y = −`along`, in metres.
    pub fn waterline(&self, along: f64) -> f64 {
        self.bends.iter().map(|b| b.amplitude * (b.step * along + b.phase).sin()).sum()
    }

    /// Returns the height of the sand above the rest level, `offshore` metres from the waterline.
    pub fn ground(&self, offshore: f64) -> f64 {
        if offshore > 0.0 {
            let power = |x: f64| x.powf(2.0 / 3.0);
            -self.deepening() * (power(offshore + self.reach) - power(self.reach))
        } else {
            self.berm * (1.0 - (offshore * self.slope / self.berm).exp())
        }
    }

    /// Returns the depth factor that makes the slope continuous at the waterline.
    fn deepening(&self) -> f64 {
        1.5 * self.slope * self.reach.cbrt()
    }
}

shared_struct! {
    /// The uniform block `Shore` in `passes/ocean/shore.glsl`; zero without a shore.
    #[derive(Default)]
    pub struct ShoreGpu for "Shore" {
        /// Profile of the beach: slope, berm, reach, and depth factor.
        pub profile: [f32; 4],
        /// Amplitudes of the bends.
        pub line_amplitude: [f32; 4],
        /// Wave numbers of the bends.
        pub line_step: [f32; 4],
        /// Phases of the bends.
        pub line_phase: [f32; 4],
        /// Swell: phase in cycles, number of whole cycles so far, period, and run-up.
        pub swell: [f32; 4],
        /// Albedo of wet sand (rgb); w is unused.
        pub bed: [f32; 4],
        /// Extinction of light in the water, per metre.
        pub extinction: [f32; 4],
        /// Water depth at which each cascade's waves keep 63 % of their height, in metres.
        pub calm: [[f32; 4]; 2],
    }
}

/// Water depth at which a cascade's waves keep 63 % of their height, in standard deviations of the height. With this value, even
/// the highest waves stay lower than the water depth.
const CALM: f64 = 6.0;

impl ShoreGpu {
    /// Creates the block of a shore at `time` seconds, for cascades with these standard deviations of the height.
    pub fn new(shore: &Shore, time: f64, deviations: &[f64]) -> Self {
        let four = |f: &dyn Fn(&Bend) -> f64| shore.bends.each_ref().map(|b| f(b) as f32);
        let turns = time.rem_euclid(PERIOD) / PERIOD * f64::from(shore.swells);
        let mut calm = [[1.0; 4]; 2];
        for (slot, deviation) in calm.as_flattened_mut().iter_mut().zip(deviations) {
            *slot = (CALM * deviation).max(1e-4) as f32;
        }
        Self {
            profile: [shore.slope, shore.berm, shore.reach, shore.deepening()].map(|v| v as f32),
            line_amplitude: four(&|b| b.amplitude),
            line_step: four(&|b| b.step),
            line_phase: four(&|b| b.phase),
            swell: [turns.fract(), turns.floor(), PERIOD / f64::from(shore.swells.max(1)), shore.run_up]
                .map(|v| v as f32),
            bed: shore.bed.extend(0.0).to_array(),
            extinction: shore.extinction.extend(0.0).to_array(),
            calm,
        }
    }
}
