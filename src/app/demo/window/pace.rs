//! Adapts the quality of moving pictures to the best quality that the device can draw within the frame time.

use leadr_gpu::Gpu;
use leadr_render::settings::{Probes, Quadrature, RenderSettings, ShadingOptions};
use leadr_scenes::config::DEFAULT_MSAA;

/// The default of the lowest frame rate of moving pictures, in frames per second.
pub const DEFAULT_MIN_FPS: f32 = 10.0;
/// The fraction of the allowed frame time below which the quality rises by one step. A step is expected to increase the frame time by at
/// most half.
const FAST: f32 = 0.5;
/// The number of frames whose median is compared, so that a single frame that creates pipelines has no effect.
const FRAMES: usize = 7;
/// The number of consecutive frames over [`FAR`] times the allowed time after which the quality drops by several steps at once. The number
/// exceeds three, because up to three consecutive frames may create pipelines.
const FAR_FRAMES: usize = 4;
const FAR: f32 = 2.0;
/// The scale of the picture's sides relative to the window, for each step. The first step reduces only the numbers of probes and geometry
/// samples.
const SCALES: [f32; 6] = [1.0, 1.0, 0.75, 0.5, 0.35, 0.25];
/// The first step on a software device, on which the first picture should appear soon.
const SLOW_STEP: usize = 4;

/// The quality settings that moving pictures always keep. By default, slow frames first lose multisampling and probes, and then pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptQuality {
    /// The fixed number of geometry samples per pixel, if there is one.
    pub msaa: Option<u32>,
    /// Whether the number of probes is fixed.
    pub probes: bool,
    /// The target frame rate in frames per second. With 0, all pixels are kept.
    pub min_fps: f32,
}

impl Default for KeptQuality {
    fn default() -> Self {
        Self { msaa: None, probes: false, min_fps: DEFAULT_MIN_FPS }
    }
}

/// Adapts quality to the time of recent frames.
#[derive(Clone, Debug)]
pub struct Pace {
    kept: KeptQuality,
    /// An index into [`SCALES`].
    step: usize,
    /// The times in milliseconds of the latest consecutive frames at this step.
    recent: Vec<f32>,
}

impl Pace {
    /// Creates the initial pace for a device. A software device starts at a lower quality.
    pub fn on(gpu: &Gpu, kept: KeptQuality) -> Self {
        let slow = if kept.min_fps > 0.0 { SLOW_STEP } else { 1 };
        Self::new(kept, if gpu.is_lavapipe() { slow } else { 0 })
    }

    /// Creates a pace at this step of [`SCALES`].
    fn new(kept: KeptQuality, step: usize) -> Self {
        Self { kept, step, recent: Vec::new() }
    }

    /// Returns the settings of a moving picture, with one sample at the current quality.
    pub fn moving(&self, still: &RenderSettings) -> RenderSettings {
        let simple = self.step > 0;
        let reference = still.shading.technique().is_reference();
        let msaa = if reference { 1 } else { self.kept.msaa.unwrap_or(if simple { 1 } else { DEFAULT_MSAA }) };
        let fewer = |quadrature| match quadrature {
            Quadrature::VisibleSlopes(Probes::Sixteen) => Quadrature::VisibleSlopes(Probes::Nine),
            other => other,
        };
        let shading = match simple && !self.kept.probes {
            true => {
                still.shading.adjusted(|options| ShadingOptions { quadrature: fewer(options.quadrature), ..options })
            }
            false => still.shading,
        };
        let scaled = |pixels: u32| ((pixels as f32 * SCALES[self.step]) as u32).max(1);
        let size = (scaled(still.size.0), scaled(still.size.1));
        RenderSettings { size, samples: 1, msaa, shading, ..*still }
    }

    /// Records the time of a moving picture's frame, and adapts the quality.
    pub fn frame(&mut self, milliseconds: f32) {
        self.recent.push(milliseconds);
        // A target of 0 allows only the first step, which is judged by the default frame rate.
        let most = 1000.0 / if self.kept.min_fps > 0.0 { self.kept.min_fps } else { DEFAULT_MIN_FPS };
        let last = if self.kept.min_fps > 0.0 { SCALES.len() - 1 } else { 1 };
        if let Some(far) = self.recent.last_chunk::<FAR_FRAMES>()
            && far.iter().all(|time| *time > FAR * most)
        {
            let least = far.iter().copied().fold(f32::MAX, f32::min);
            let fits = |step: &usize| least * (SCALES[*step] / SCALES[self.step]).powi(2) <= most;
            self.step = (self.step + 1..last).find(fits).unwrap_or(last).max(self.step);
            self.recent.clear();
            return;
        }
        if self.recent.len() < FRAMES {
            return;
        }
        let mut sorted = std::mem::take(&mut self.recent);
        sorted.sort_unstable_by(f32::total_cmp);
        let median = sorted[FRAMES / 2];
        if median > most {
            self.step = (self.step + 1).min(last);
        } else if median < FAST * most {
            self.step = self.step.saturating_sub(1);
        }
    }

    /// Discards the recorded frames after an interruption.
    pub fn interrupt(&mut self) {
        self.recent.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(pace: &mut Pace, milliseconds: f32) {
        (0..FRAMES).for_each(|_| pace.frame(milliseconds));
    }

    #[test]
    fn slow_pictures_become_simpler_and_stay_so() {
        let still = RenderSettings { samples: 4, ..RenderSettings::default() };
        let mut pace = Pace::new(KeptQuality::default(), 0);
        let full = pace.moving(&still);
        assert_eq!((full.samples, full.msaa, full.shading), (1, DEFAULT_MSAA, still.shading));
        frames(&mut pace, 99.0);
        assert_eq!(pace.moving(&still), full);
        // These slow frames create pipelines, or follow a pause.
        pace.frame(2000.0);
        pace.interrupt();
        (0..3).for_each(|_| pace.frame(2000.0));
        (0..4).for_each(|_| pace.frame(60.0));
        assert_eq!(pace.moving(&still), full);
        frames(&mut pace, 140.0);
        let simple = pace.moving(&still);
        assert_eq!((simple.samples, simple.msaa), (1, 1));
        let nine = Quadrature::VisibleSlopes(Probes::Nine);
        assert_eq!(simple.shading.options().quadrature, nine);
        // Simple frames take less time. The quality rises only if full frames would be fast enough.
        frames(&mut pace, 90.0);
        assert_eq!(pace.moving(&still), simple);
        frames(&mut pace, 30.0);
        assert_eq!(pace.moving(&still), full);
    }

    #[test]
    fn clock_jumps_do_not_change_pictures() {
        let still = RenderSettings { size: (640, 360), ..RenderSettings::default() };
        for odd in [0.0, 1e9, f32::INFINITY, -1e9] {
            let mut pace = Pace::new(KeptQuality::default(), 1);
            let usual = pace.moving(&still);
            for _ in 0..5 {
                (0..3).for_each(|_| pace.frame(80.0));
                pace.frame(odd);
                (0..3).for_each(|_| pace.frame(80.0));
            }
            assert_eq!(pace.moving(&still), usual, "{odd}");
        }
    }

    #[test]
    fn pictures_that_are_simple_and_slow_lose_pixels_and_get_them_back() {
        let still = RenderSettings { size: (640, 360), ..RenderSettings::default() };
        let mut pace = Pace::new(KeptQuality::default(), 1);
        frames(&mut pace, 150.0);
        assert_eq!(pace.moving(&still).size, (480, 270));
        // Very slow frames lower the quality by several steps at once.
        (0..4).for_each(|_| pace.frame(600.0));
        assert_eq!(pace.moving(&still).size, (160, 90));
        frames(&mut pace, 700.0);
        assert_eq!(pace.moving(&still).size, (160, 90));
        frames(&mut pace, 80.0);
        assert_eq!(pace.moving(&still).size, (160, 90));
        (0..4).for_each(|_| frames(&mut pace, 40.0));
        assert_eq!(pace.moving(&still).size, (640, 360));
        // A target of 30 frames per second is missed earlier. A target of 0 keeps all pixels.
        let mut pace = Pace::new(KeptQuality { min_fps: 30.0, ..Default::default() }, 1);
        frames(&mut pace, 40.0);
        assert_eq!(pace.moving(&still).size, (480, 270));
        let mut pace = Pace::new(KeptQuality { min_fps: 0.0, ..Default::default() }, 1);
        (0..5).for_each(|_| frames(&mut pace, 4000.0));
        assert_eq!(pace.moving(&still).size, (640, 360));
        assert_eq!(Pace::new(KeptQuality::default(), 0).moving(&RenderSettings { size: (1, 1), ..still }).size, (1, 1));
    }

    #[test]
    fn settings_are_kept() {
        let still = RenderSettings { samples: 4, msaa: 2, ..RenderSettings::default() };
        let both = KeptQuality { msaa: Some(2), probes: true, ..Default::default() };
        assert_eq!(Pace::new(both, 1).moving(&still), RenderSettings { samples: 1, ..still });
        let probes = Pace::new(KeptQuality { probes: true, ..Default::default() }, 1).moving(&still);
        assert_eq!((probes.msaa, probes.shading), (1, still.shading));
        let msaa = Pace::new(KeptQuality { msaa: Some(2), ..Default::default() }, 1).moving(&still);
        assert!(msaa.msaa == 2 && msaa.shading != still.shading);
    }

    #[test]
    fn fewer_probes_are_not_made_more() {
        let options = ShadingOptions { quadrature: Quadrature::VisibleSlopes(Probes::Five), ..Default::default() };
        let still = RenderSettings::default();
        let still = RenderSettings { shading: still.shading.adjusted(|_| options), ..still };
        let simple = Pace::new(KeptQuality::default(), 1).moving(&still);
        assert_eq!(simple.shading, still.shading);
    }
}
