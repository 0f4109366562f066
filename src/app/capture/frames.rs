//! The moments that a capture draws.

use serde::{Serialize, Serializer};

use crate::app::flags::values::{FrameRange, Rate, Shard};
use leadr_render::settings::Technique;
use leadr_scenes::stage::{Sweep, turntable_degrees};

/// One moment of the animation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// The number of the frame, or 0 for a still.
    pub frame: u32,
    /// The time since the start of the animation in seconds.
    pub time: f64,
    /// The distance between the camera and its target in metres, only in a sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f32>,
    /// The rotation of the camera around its target in degrees, only in a turntable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn_degrees: Option<f32>,
    /// The technique of this picture, only in a comparison of techniques.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "name_of")]
    pub technique: Option<Technique>,
}

fn name_of<S: Serializer>(technique: &Option<Technique>, serializer: S) -> Result<S::Ok, S::Error> {
    technique.map(Technique::name).serialize(serializer)
}

/// The moments of a whole capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Timeline {
    /// A single picture.
    Still {
        /// The time since the start of the animation in seconds.
        time: f64,
    },
    /// Frames at constant steps of time.
    Sequence {
        /// The range of frame numbers.
        frames: FrameRange,
        /// The number of frames per second.
        fps: Rate,
        /// The part of the range that this process renders.
        shard: Option<Shard>,
        /// The camera motion that replaces time.
        #[serde(flatten, skip_serializing_if = "Option::is_none")]
        travel: Option<Travel>,
    },
}

/// Selects `count` of `moments` at equal steps, including the first. The selection of a sweep also includes the end. Other sequences
/// continue or repeat after their end, so the end is left out.
pub fn spread(moments: &[Moment], count: usize) -> Vec<Moment> {
    let closed = moments.last().is_some_and(|moment| moment.distance.is_some());
    let at = |i: usize| {
        if closed {
            (2 * i * (moments.len() - 1) + count - 1) / (2 * (count - 1).max(1))
        } else {
            i * moments.len() / count
        }
    };
    (0..count).filter_map(|i| moments.get(at(i)).copied()).collect()
}

/// A camera motion during which the scene does not move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Travel {
    /// The time since the start of the animation in seconds.
    pub time: f64,
    /// The motion of the camera away from the target or towards it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Whether the camera moves once around its target.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub turntable: bool,
}

impl Timeline {
    /// Returns the frames of the whole capture, including all shards. A still has the frame number 0.
    pub fn frames(&self) -> FrameRange {
        match *self {
            Self::Still { .. } => FrameRange { start: 0, end: 1 },
            Self::Sequence { frames, .. } => frames,
        }
    }

    /// Returns the moments of this process, in order. The shards of a range are disjoint and cover the range.
    pub fn moments(&self) -> Vec<Moment> {
        match *self {
            Self::Still { time } => {
                vec![Moment { frame: 0, time, distance: None, turn_degrees: None, technique: None }]
            }
            Self::Sequence { frames, fps, shard, travel } => {
                let Shard { index, count } = shard.unwrap_or(Shard { index: 1, count: 1 });
                let numbers = (frames.start..frames.end).skip(index as usize - 1).step_by(count as usize);
                let moment = |frame| {
                    let (step, steps) = (frame - frames.start, frames.end - frames.start);
                    // A division, unlike accumulation, makes the time of a frame independent of its shard.
                    let running = f64::from(frame) / fps.per_second();
                    Moment {
                        frame,
                        time: travel.map_or(running, |travel| travel.time),
                        distance: travel.and_then(|travel| travel.sweep).map(|sweep| sweep.distance(step, steps)),
                        turn_degrees: travel.filter(|t| t.turntable).map(|_| turntable_degrees(step, steps)),
                        technique: None,
                    }
                };
                numbers.map(moment).collect()
            }
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Returns a sequence at 24 frames per second.
    pub fn sequence(start: u32, end: u32, shard: Option<Shard>) -> Timeline {
        Timeline::Sequence { frames: FrameRange { start, end }, fps: fps(), shard, travel: None }
    }

    fn fps() -> Rate {
        "24".parse().unwrap()
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
        let travel = Some(Travel { time: 1.5, sweep: Some(Sweep { near: 2.0, far: 18.0 }), turntable: false });
        let frames = FrameRange { start: 7, end: 10 };
        let moments = Timeline::Sequence { frames, fps: fps(), shard: None, travel }.moments();
        let seen: Vec<_> = moments.iter().map(|m| (m.frame, m.time, m.distance.unwrap().round())).collect();
        assert_eq!(seen, [(7, 1.5, 2.0), (8, 1.5, 6.0), (9, 1.5, 18.0)]);
        let second = Timeline::Sequence { frames, fps: fps(), shard: Some(Shard { index: 2, count: 3 }), travel };
        assert_eq!(second.moments(), moments[1..2]);
    }
    #[test]
    fn turntable_rotates_with_frozen_time() {
        let travel = Some(Travel { time: 0.5, sweep: None, turntable: true });
        let frames = FrameRange { start: 4, end: 8 };
        let timeline = Timeline::Sequence { frames, fps: fps(), shard: None, travel };
        let seen: Vec<_> = timeline.moments().iter().map(|m| (m.frame, m.time, m.distance, m.turn_degrees)).collect();
        let at = |frame, degrees| (frame, 0.5, None, Some(degrees));
        assert_eq!(seen, [at(4, 0.0), at(5, 90.0), at(6, 180.0), at(7, 270.0)]);
        let json = serde_json::to_value(timeline).unwrap();
        assert_eq!((&json["sequence"]["time"], &json["sequence"]["fps"]), (&0.5.into(), &24.0.into()));
        assert_eq!(
            (&json["sequence"]["turntable"], &json["sequence"]["sweep"]),
            (&true.into(), &serde_json::Value::Null)
        );
    }
    #[test]
    fn moments_are_spread_evenly() {
        let numbers = |moments: &[Moment], count| spread(moments, count).iter().map(|m| m.frame).collect::<Vec<_>>();
        let running = sequence(10, 22, None).moments();
        assert_eq!(numbers(&running, 4), [10, 13, 16, 19]);
        assert_eq!(numbers(&running, 5), [10, 12, 14, 17, 19]);
        assert_eq!(numbers(&running, 12), (10..22).collect::<Vec<_>>());
        let away: Vec<_> = running.iter().map(|m| Moment { distance: Some(1.0), ..*m }).collect();
        assert_eq!((numbers(&away, 3), numbers(&away, 1)), (vec![10, 16, 21], vec![10]));
        assert_eq!(numbers(&away, 12), numbers(&running, 12));
    }
}
