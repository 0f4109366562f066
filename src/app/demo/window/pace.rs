//! How well a moving picture is drawn: as well as the device manages at ten frames a second.

use crate::gpu::Gpu;
use crate::render::settings::{Probes, Quadrature, RenderSettings, ShadingOptions};
use crate::scenes::config::DEFAULT_MSAA;

/// Frames that take longer make a moving picture simpler.
const SLOW: f32 = 100.0;
/// Frames of a simpler picture that take less make it better again: what it leaves out costs at most half as much again.
const FAST: f32 = 50.0;
/// Frames whose median counts. One that makes pipelines is no reason.
const FRAMES: usize = 7;

/// What of moving pictures does not follow the pace. By default their geometry is multisampled, or if frames take long not, and
/// these look the environment up at fewer probes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KeptQuality {
    /// Samples of the geometry in each pixel, if they are given.
    pub msaa: Option<u32>,
    /// Whether the probes stay.
    pub probes: bool,
}

/// Follows how long frames take.
#[derive(Debug)]
pub struct Pace {
    kept: KeptQuality,
    simple: bool,
    /// Milliseconds of the last frames that were drawn alike, one after the other.
    recent: Vec<f32>,
}

impl Pace {
    /// The pace of a device before its first frame: that of a processor which draws by itself is slow.
    #[must_use]
    pub fn on(gpu: &Gpu, kept: KeptQuality) -> Self {
        Self::new(kept, gpu.is_lavapipe())
    }

    /// `simple`: whether the first frames are the simpler ones.
    #[must_use]
    pub fn new(kept: KeptQuality, simple: bool) -> Self {
        Self { kept, simple, recent: Vec::new() }
    }

    /// The settings of a moving picture: one sample of those of a still one.
    #[must_use]
    pub fn moving(&self, still: &RenderSettings) -> RenderSettings {
        let msaa = self.kept.msaa.unwrap_or(if self.simple { 1 } else { DEFAULT_MSAA });
        let fewer = |quadrature| match quadrature {
            Quadrature::VisibleSlopes(Probes::Sixteen) => Quadrature::VisibleSlopes(Probes::Nine),
            other => other,
        };
        let shading = match self.simple && !self.kept.probes {
            true => {
                still.shading.adjusted(|options| ShadingOptions { quadrature: fewer(options.quadrature), ..options })
            }
            false => still.shading,
        };
        RenderSettings { samples: 1, msaa, shading, ..*still }
    }

    /// A frame of a moving picture took so many milliseconds.
    pub fn frame(&mut self, milliseconds: f32) {
        self.recent.push(milliseconds);
        if self.recent.len() < FRAMES {
            return;
        }
        let mut sorted = std::mem::take(&mut self.recent);
        sorted.sort_unstable_by(f32::total_cmp);
        let median = sorted[FRAMES / 2];
        self.simple = median > if self.simple { FAST } else { SLOW };
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
        let mut pace = Pace::new(KeptQuality::default(), false);
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
    fn what_is_set_is_kept() {
        let still = RenderSettings { samples: 4, msaa: 2, ..RenderSettings::default() };
        let both = KeptQuality { msaa: Some(2), probes: true };
        assert_eq!(Pace::new(both, true).moving(&still), RenderSettings { samples: 1, ..still });
        let probes = Pace::new(KeptQuality { probes: true, ..Default::default() }, true).moving(&still);
        assert_eq!((probes.msaa, probes.shading), (1, still.shading));
        let msaa = Pace::new(KeptQuality { msaa: Some(2), ..Default::default() }, true).moving(&still);
        assert!(msaa.msaa == 2 && msaa.shading != still.shading);
    }

    #[test]
    fn fewer_probes_are_not_made_more() {
        let options = ShadingOptions { quadrature: Quadrature::VisibleSlopes(Probes::Five), ..Default::default() };
        let still = RenderSettings::default();
        let still = RenderSettings { shading: still.shading.adjusted(|_| options), ..still };
        let simple = Pace::new(KeptQuality::default(), true).moving(&still);
        assert_eq!(simple.shading, still.shading);
    }
}
