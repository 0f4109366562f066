//! A beach of the sea. The coast runs along y, and land is toward +x. The shader code is in `passes/ocean/shore.glsl`. Parity tests
//! compare [`Shore::offshore`] and [`Shore::ground`] with their GLSL versions.

use glam::{DVec2, Vec3};
use leadr_gpu::shared_struct;

use super::waves::PERIOD;

/// A sinusoidal bend of the waterline, by `amplitude · sin(step · along + phase)` metres toward the sea.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// The amplitude in metres.
    pub amplitude: f64,
    /// The wave number along the coast, in rad/m.
    pub step: f64,
    /// The phase in radians.
    pub phase: f64,
}

/// A beach, and the swell that runs onto it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shore {
    /// The slope of the sand at the rest waterline, which is greater than 0.
    pub slope: f64,
    /// The height of the flat sand behind the beach above the water, in metres, greater than 0.
    pub berm: f64,
    /// The distance in metres over which the sea floor levels off. The depth is proportional to `(s + reach)^⅔ − reach^⅔`, which is
    /// Dean's equilibrium profile, shifted for a finite slope at the waterline.
    pub reach: f64,
    /// The bends of the waterline, which otherwise lies at x = 0.
    pub bends: [Bend; 4],
    /// The number of swell waves per [`PERIOD`], which is greater than 0.
    pub swells: u32,
    /// The height to which the highest waves run up above the rest level, in metres.
    pub run_up: f64,
    /// The linear albedo of wet sand.
    pub bed: Vec3,
    /// The extinction of light in the water, per metre.
    pub extinction: Vec3,
}

impl Shore {
    /// Returns the distance from the waterline in metres, which is positive toward the sea.
    pub fn offshore(&self, point: DVec2) -> f64 {
        -point.x - self.waterline(-point.y)
    }

    /// Returns −x of the waterline at rest, in metres, at y = −`along`.
    pub fn waterline(&self, along: f64) -> f64 {
        self.bends.iter().map(|b| b.amplitude * (b.step * along + b.phase).sin()).sum()
    }

    /// Returns the height of the sand above the rest level, at `offshore` metres from the waterline.
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
    /// The uniform block `Shore` in `passes/ocean/shore.glsl`, which is zero without a shore.
    #[derive(Default)]
    pub struct ShoreGpu for "Shore" {
        /// The profile of the beach: slope, berm, reach, and depth factor.
        pub profile: [f32; 4],
        /// The amplitudes of the bends.
        pub line_amplitude: [f32; 4],
        /// The wave numbers of the bends.
        pub line_step: [f32; 4],
        /// The phases of the bends.
        pub line_phase: [f32; 4],
        /// The swell: phase in cycles, number of whole cycles so far, period, and run-up.
        pub swell: [f32; 4],
        /// The albedo of wet sand in rgb. The component w is unused.
        pub bed: [f32; 4],
        /// The extinction of light in the water, per metre.
        pub extinction: [f32; 4],
        /// The water depth at which the waves of each cascade keep 63 % of their height, in metres.
        pub calm: [[f32; 4]; 2],
    }
}

/// The water depth at which the waves of a cascade keep 63 % of their height, in standard deviations of the height. With this
/// value, even the highest waves stay lower than the depth of the water.
const CALM: f64 = 6.0;

impl ShoreGpu {
    /// Creates the block of a shore at `time` seconds. The standard deviations are those of the height of each cascade.
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
