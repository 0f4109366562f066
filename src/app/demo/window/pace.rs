//! How well a moving picture is drawn: as well as the device manages in the time that a frame may take.

use leadr_gpu::Gpu;
use leadr_render::settings::{Probes, Quadrature, RenderSettings, ShadingOptions};
use leadr_scenes::config::DEFAULT_MSAA;

/// Frames a second below which a moving picture becomes simpler, if nobody says otherwise.
pub const DEFAULT_MIN_FPS: f32 = 10.0;
/// Frames that take less than this share of the time they may take make it better again: what a step leaves out costs at most half as
/// much again.
const FAST: f32 = 0.5;
/// Frames whose median counts. One that makes pipelines is no reason.
const FRAMES: usize = 7;
/// Frames in a row that take more than [`FAR`] times too long and so take several steps at once. Three may make pipelines.
const FAR_FRAMES: usize = 4;
const FAR: f32 = 2.0;
/// Share of the window's pixels along each side that is drawn, step by step. The first step has fewer probes and samples of the geometry
/// instead.
const SCALES: [f32; 6] = [1.0, 1.0, 0.75, 0.5, 0.35, 0.25];
/// The step that a processor begins with which draws by itself: the window shows something sooner.
const SLOW_STEP: usize = 4;

/// What of moving pictures does not follow the pace. By default their geometry is multisampled, or if frames take long not, and
/// these look the environment up at fewer probes, and then have fewer pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptQuality {
    /// Samples of the geometry in each pixel, if they are given.
    pub msaa: Option<u32>,
    /// Whether the probes stay.
    pub probes: bool,
    /// Frames a second for which moving pictures may become simpler; at 0 they have all pixels.
    pub min_fps: f32,
}

impl Default for KeptQuality {
    fn default() -> Self {
        Self { msaa: None, probes: false, min_fps: DEFAULT_MIN_FPS }
    }
}

/// Follows how long frames take.
#[derive(Debug)]
pub struct Pace {
    kept: KeptQuality,
    /// Of [`SCALES`].
    step: usize,
    /// Milliseconds of the last frames that were drawn alike, one after the other.
    recent: Vec<f32>,
}

impl Pace {
    /// The pace of a device before its first frame: that of a processor which draws by itself is slow.
    pub fn on(gpu: &Gpu, kept: KeptQuality) -> Self {
        let slow = if kept.min_fps > 0.0 { SLOW_STEP } else { 1 };
        Self::new(kept, if gpu.is_lavapipe() { slow } else { 0 })
    }

    /// `step`: how much simpler the first frames are, from 0.
    fn new(kept: KeptQuality, step: usize) -> Self {
        Self { kept, step, recent: Vec::new() }
    }

    /// The settings of a moving picture: one sample of those of a still one.
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

    /// A frame of a moving picture took so many milliseconds.
    pub fn frame(&mut self, milliseconds: f32) {
        self.recent.push(milliseconds);
        // At 0 frames a second the first step is still there for those who set nothing else.
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

    /// Something came between the frames.
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
        // Frames that make pipelines, and a pause.
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
        // Simple frames take less time, which is no reason to go back until full ones would be fast.
        frames(&mut pace, 90.0);
        assert_eq!(pace.moving(&still), simple);
        frames(&mut pace, 30.0);
        assert_eq!(pace.moving(&still), full);
    }

    #[test]
    fn a_clock_that_jumps_changes_no_picture() {
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
        // Much too slow: several steps at once.
        (0..4).for_each(|_| pace.frame(600.0));
        assert_eq!(pace.moving(&still).size, (160, 90));
        frames(&mut pace, 700.0);
        assert_eq!(pace.moving(&still).size, (160, 90));
        frames(&mut pace, 80.0);
        assert_eq!(pace.moving(&still).size, (160, 90));
        (0..4).for_each(|_| frames(&mut pace, 40.0));
        assert_eq!(pace.moving(&still).size, (640, 360));
        // Thirty frames a second are harder to reach, none at all keep the pixels.
        let mut pace = Pace::new(KeptQuality { min_fps: 30.0, ..Default::default() }, 1);
        frames(&mut pace, 40.0);
        assert_eq!(pace.moving(&still).size, (480, 270));
        let mut pace = Pace::new(KeptQuality { min_fps: 0.0, ..Default::default() }, 1);
        (0..5).for_each(|_| frames(&mut pace, 4000.0));
        assert_eq!(pace.moving(&still).size, (640, 360));
        assert_eq!(Pace::new(KeptQuality::default(), 0).moving(&RenderSettings { size: (1, 1), ..still }).size, (1, 1));
    }

    #[test]
    fn what_is_set_is_kept() {
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
