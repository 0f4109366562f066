//! Which moments a capture shows, and the names of the files they go to.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::app::error::AppError;
use crate::app::files::extension;
use crate::app::flags::values::{FrameRange, Shard};
use crate::scenes::stage::Sweep;

/// One moment of the animation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Frame number; 0 for a still.
    pub frame: u32,
    /// Seconds since the start of the animation.
    pub time: f64,
    /// Metres between camera and target, in a sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f32>,
}

/// The moments of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Timeline {
    /// One picture.
    Still {
        /// Seconds since the start of the animation.
        time: f64,
    },
    /// Frames at a fixed step.
    Sequence {
        /// Frame numbers.
        frames: FrameRange,
        /// Frames per second.
        fps: f64,
        /// The part of the range that this call renders.
        shard: Option<Shard>,
        /// The camera moves instead of time.
        #[serde(skip_serializing_if = "Option::is_none")]
        sweep: Option<Sweep>,
    },
}

impl Timeline {
    /// The moments of this call, in order. Shards of one range are disjoint and cover it.
    #[must_use]
    pub fn moments(&self) -> Vec<Moment> {
        match *self {
            Self::Still { time } => vec![Moment { frame: 0, time, distance: None }],
            Self::Sequence { frames, fps, shard, sweep } => {
                let Shard { index, count } = shard.unwrap_or(Shard { index: 1, count: 1 });
                let numbers = (frames.start..frames.end).skip(index as usize - 1).step_by(count as usize);
                let moment = |frame| match sweep {
                    // Divided, not accumulated: a frame's time does not depend on the shard it is in.
                    None => Moment { frame, time: f64::from(frame) / fps, distance: None },
                    Some(sweep) => {
                        let distance = sweep.distance(frame - frames.start, frames.end - frames.start);
                        Moment { frame, time: 0.0, distance: Some(distance) }
                    }
                };
                numbers.map(moment).collect()
            }
        }
    }
}

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FileKind {
    /// Tonemapped, sRGB, 8 bits.
    Png,
    /// Linear radiance, 32-bit floats, with layers.
    Exr,
}

/// A path, with `{frame}` for the number of a frame in four digits or more.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OutputPattern {
    pattern: PathBuf,
    /// Format, from the path's extension.
    pub kind: FileKind,
}

/// Placeholder of the frame number in a path.
pub const FRAME: &str = "{frame}";

impl OutputPattern {
    /// Checks a pattern against what is to be written.
    ///
    /// # Errors
    /// [`AppError::Usage`] if the extension is neither `.png` nor `.exr`, or if `{frame}` is missing for a
    /// sequence or present for a still.
    pub fn new(path: &Path, timeline: &Timeline) -> Result<Self, AppError> {
        let shown = path.display();
        let kind = match extension(path).as_deref() {
            Some("png") => FileKind::Png,
            Some("exr") => FileKind::Exr,
            _ => return Err(AppError::Usage(format!("output '{shown}' must end in .png or .exr"))),
        };
        let numbered = path.to_str().is_some_and(|text| text.contains(FRAME));
        match timeline {
            Timeline::Sequence { .. } if !numbered => Err(AppError::Usage(format!(
                "output '{shown}' names one file for many frames; write {FRAME} where the number goes"
            ))),
            Timeline::Still { .. } if numbered => {
                Err(AppError::Usage(format!("output '{shown}' has {FRAME}, which needs --frames")))
            }
            _ => Ok(Self { pattern: path.to_owned(), kind }),
        }
    }

    /// The file of one frame.
    #[must_use]
    pub fn path(&self, frame: u32) -> PathBuf {
        // A path that is not UTF-8 has no `{frame}` (see `new`).
        match self.pattern.to_str() {
            Some(text) => text.replace(FRAME, &format!("{frame:04}")).into(),
            None => self.pattern.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(start: u32, end: u32, shard: Option<Shard>) -> Timeline {
        Timeline::Sequence { frames: FrameRange { start, end }, fps: 24.0, shard, sweep: None }
    }

    #[test]
    fn shards_are_disjoint_and_cover_the_range() {
        let whole = sequence(5, 28, None).moments();
        let mut parts: Vec<_> =
            (1..=4).flat_map(|index| sequence(5, 28, Some(Shard { index, count: 4 })).moments()).collect();
        parts.sort_by_key(|moment| moment.frame);
        assert_eq!(parts, whole);
        assert_eq!((whole.len(), whole[0].frame, whole[19].time), (23, 5, 1.0));
        assert!(sequence(0, 2, Some(Shard { index: 3, count: 3 })).moments().is_empty());
    }

    #[test]
    fn a_sweep_moves_the_camera_and_not_the_time() {
        let sweep = Some(Sweep { near: 2.0, far: 18.0 });
        let frames = FrameRange { start: 7, end: 10 };
        let moments = Timeline::Sequence { frames, fps: 24.0, shard: None, sweep }.moments();
        let seen: Vec<_> = moments.iter().map(|m| (m.frame, m.time, m.distance.unwrap().round())).collect();
        assert_eq!(seen, [(7, 0.0, 2.0), (8, 0.0, 6.0), (9, 0.0, 18.0)]);
        let second = Timeline::Sequence { frames, fps: 24.0, shard: Some(Shard { index: 2, count: 3 }), sweep };
        assert_eq!(second.moments(), moments[1..2]);
    }

    #[test]
    fn names() {
        let walk = OutputPattern::new(Path::new("out/w-{frame}.png"), &sequence(0, 9, None)).unwrap();
        assert_eq!((walk.path(7), walk.path(12345)), ("out/w-0007.png".into(), "out/w-12345.png".into()));
        let still = OutputPattern::new(Path::new("a.EXR"), &Timeline::Still { time: 0.0 }).unwrap();
        assert_eq!((still.path(0), still.kind), ("a.EXR".into(), FileKind::Exr));
    }

    #[test]
    fn patterns_that_cannot_work_are_refused() {
        assert!(OutputPattern::new(Path::new("a.png"), &sequence(0, 9, None)).is_err());
        assert!(OutputPattern::new(Path::new("a-{frame}.png"), &Timeline::Still { time: 0.0 }).is_err());
        assert!(OutputPattern::new(Path::new("a.jpg"), &Timeline::Still { time: 0.0 }).is_err());
        assert!(OutputPattern::new(Path::new("a"), &Timeline::Still { time: 0.0 }).is_err());
    }
}
