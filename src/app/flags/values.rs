//! The values of command-line flags, and their parsers.

use std::str::FromStr;

use serde::Serialize;

use leadr_render::settings::numbers::{positive, share};
use leadr_scenes::stage::Sweep;
use leadr_scenes::view::TIMES;

/// Parses a finite number in double precision, which must be at least 0.
pub fn threshold(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        Ok(value) if value < 0.0 => Err("must not be negative".to_owned()),
        _ => Err(format!("'{text}' is not a finite number")),
    }
}

/// Parses the two numbers before and after a separator.
fn two(sides: Option<(&str, &str)>) -> Option<[u32; 2]> {
    let (a, b) = sides?;
    Some([a.parse().ok()?, b.parse().ok()?])
}

/// The frames from `start` up to, but not including, `end`. The range is written as `A..B`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FrameRange {
    /// The first frame.
    pub start: u32,
    /// The number after the last frame, which is above `start`.
    pub end: u32,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a frame range is A..B with A below B, such as 0..48 for frames 0 to 47";
        match two(text.split_once("..")) {
            Some([start, end]) if start < end && end <= 1_000_000 => Ok(Self { start, end }),
            Some([_, end]) if end > 1_000_000 => Err("a frame number is at most 1000000".to_owned()),
            _ => Err(form.to_owned()),
        }
    }
}

/// A number of frames per second as an exact fraction, 0.001 to 1000. The rate is written as a decimal (`24`, `29.97`) or a fraction
/// (`30000/1001`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    numerator: u32,
    denominator: u32,
}

impl Rate {
    /// The default of 30 frames per second.
    pub const DEFAULT: Self = Self { numerator: 30, denominator: 1 };

    /// Returns the numerator of the reduced fraction, above 0.
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// Returns the denominator of the reduced fraction, above 0.
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// Returns the frames per second.
    pub fn per_second(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    fn new(numerator: u32, denominator: u32) -> Option<Self> {
        let (mut divisor, mut rest) = (numerator, denominator);
        while rest > 0 {
            (divisor, rest) = (rest, divisor % rest);
        }
        // The divisor is 0 only if both numbers are 0. The code below refuses this case.
        let rate = Self { numerator: numerator / divisor.max(1), denominator: denominator / divisor.max(1) };
        (denominator > 0 && (0.001..=1000.0).contains(&rate.per_second())).then_some(rate)
    }

    fn parse(text: &str) -> Option<Self> {
        if let Some(fraction) = text.split_once('/') {
            let [numerator, denominator] = two(Some(fraction))?;
            return Self::new(numerator, denominator);
        }
        let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
        let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
        if !(digits(whole) && digits(decimals) && decimals.len() <= 6) {
            return None;
        }
        Self::new(format!("{whole}{decimals}").parse().ok()?, 10_u32.pow(decimals.len() as u32))
    }
}

impl FromStr for Rate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a frame rate is a number from 0.001 to 1000 with at most six decimals, or a fraction, such as 24, 29.97 or 30000/1001";
        Self::parse(text).ok_or_else(|| form.to_owned())
    }
}

impl Serialize for Rate {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.per_second())
    }
}

/// Parses the distances to the target at the first and the last frame. They are in metres, and written as `NEAR..FAR`.
pub fn sweep(text: &str) -> Result<Sweep, String> {
    let (near, far) = text.split_once("..").ok_or("a sweep is NEAR..FAR in metres, such as 5..100")?;
    Ok(Sweep { near: positive(near)?, far: positive(far)? })
}

/// A contact sheet of `columns` by `rows` pictures, written as `COLUMNSxROWS`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Sheet {
    /// The number of columns, 1 to 1000.
    pub columns: u32,
    /// The number of rows, 1 to 1000.
    pub rows: u32,
}

impl Sheet {
    /// Returns the number of pictures.
    pub fn cells(self) -> u32 {
        self.columns * self.rows
    }
}

impl FromStr for Sheet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a sheet is COLUMNSxROWS with 1 to 1000 of each, such as 4x3";
        match two(text.split_once(TIMES)) {
            Some(sides @ [columns, rows]) if sides.iter().all(|n| (1..=1000).contains(n)) => Ok(Self { columns, rows }),
            _ => Err(form.to_owned()),
        }
    }
}

/// The position at which the right side of a picture starts, as a fraction of the width. In a sequence, the position moves from `start` to
/// `end` and back. The split is written as `SHARE` or `A..B`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// The position at the first frame, or in a still.
    pub start: f32,
    /// The position in the middle of a sequence.
    pub end: f32,
}

impl Default for Split {
    fn default() -> Self {
        Self { start: 0.5, end: 0.5 }
    }
}

impl Split {
    /// Returns the position at a frame of a sequence. The sequence is periodic: its first frame follows its last frame.
    pub fn of_frame(self, frame: u32, frames: FrameRange) -> f32 {
        self.at(frame - frames.start, frames.end - frames.start)
    }

    fn at(self, step: u32, steps: u32) -> f32 {
        let turn = f64::from(step) / f64::from(steps.max(1)) * std::f64::consts::TAU;
        self.start + (self.end - self.start) * (0.5 - 0.5 * turn.cos()) as f32
    }
}

impl FromStr for Split {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (start, end) = text.split_once("..").unwrap_or((text, text));
        Ok(Self { start: share(start)?, end: share(end)? })
    }
}

/// Every `count`-th frame, starting with the frame `index`. A shard is written as `I/N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Shard {
    /// The number of this shard, from 1 to `count`.
    pub index: u32,
    /// The number of shards.
    pub count: u32,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a shard is I/N with I from 1 to N, such as 2/8";
        match two(text.split_once('/')) {
            Some([index, count]) if 1 <= index && index <= count => Ok(Self { index, count }),
            _ => Err(form.to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused<T: FromStr>(texts: &[&str]) {
        for text in texts {
            assert!(text.parse::<T>().is_err(), "'{text}' must be refused");
        }
    }

    #[test]
    fn frame_ranges_and_shards() {
        assert_eq!("3..7".parse(), Ok(FrameRange { start: 3, end: 7 }));
        refused::<FrameRange>(&["", "3", "7..3", "3..3", "..", "a..b", "-1..3", "0..4000000000"]);
        assert_eq!("2/8".parse(), Ok(Shard { index: 2, count: 8 }));
        let rate = |text: &str| text.parse::<Rate>().map(|rate| (rate.numerator(), rate.denominator()));
        assert_eq!((rate("24"), rate("23.976"), rate(".5")), (Ok((24, 1)), Ok((2997, 125)), Ok((1, 2))));
        assert_eq!((rate("60000/1001"), rate("50/2"), rate("0.001")), (Ok((60000, 1001)), Ok((25, 1)), Ok((1, 1000))));
        refused::<Rate>(&["", ".", "0", "0/0", "1/0", "0/1", "-1", "1e2", "1001", "0.0001", "1/1001", "nan", "1/2/3"]);
        refused::<Rate>(&["24.0000001", "99999999999", "1.2.3", "+3.-1"]);
        assert_eq!(sweep("5..0.5"), Ok(Sweep { near: 5.0, far: 0.5 }));
        assert!(["", "5", "0..4", "1..-2", "nan..2", "1..inf", "..", "a..b"].iter().all(|t| sweep(t).is_err()));
        assert_eq!("4x3".parse(), Ok(Sheet { columns: 4, rows: 3 }));
        refused::<Sheet>(&["", "4", "0x3", "4x0", "4x3x2", "axb", "1001x1", "-1x2"]);
        refused::<Shard>(&["", "2", "0/8", "9/8", "1/0", "a/b", "1/2/3"]);
    }

    #[test]
    fn splits_go_there_and_back() {
        let split: Split = "0.2..0.8".parse().unwrap();
        let at = |step| (100.0 * split.at(step, 4)).round();
        assert_eq!([0, 1, 2, 3, 4].map(at), [20.0, 50.0, 80.0, 50.0, 20.0]);
        assert_eq!("0.3".parse::<Split>().unwrap().at(1, 2), 0.3);
        refused::<Split>(&["", "2", "0.1..", "0.1..1.1", "a..b", "0..1..0"]);
    }
}
