//! Animated WebP, lossless. The pictures are encoded by `image-webp`; the container about them, which that crate does not
//! write, is here ([specification](https://developers.google.com/speed/webp/docs/riff_container)).

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use image_webp::{ColorType, WebPEncoder};

use super::frame_sink::Sink;
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::save::{Tone, display};
use crate::app::flags::values::Rate;
use leadr_maps::Rgb8Image;
use leadr_maps::new_file::NewFile;
use leadr_maps::origin::Origin;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;

/// Bytes in front of the first chunk: `RIFF`, a length, `WEBP`.
const RIFF_HEADER: usize = 12;

/// In the flags of the file: there are frames.
const ANIMATION: u8 = 1 << 1;

/// In the flags of a frame: it replaces what was there.
const NO_BLENDING: u8 = 1 << 1;

/// Writes frames into one file as they come; of earlier pictures it keeps the last one.
struct Webp {
    file: NewFile,
    riff: Riff,
    delays: Delays,
    tone: Tone,
    before: Option<Rgb8Image>,
}

/// Begins the moving picture that `config` asks for.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink>, AppError> {
    let path = config.output.path(0);
    let file = begin(&path)?;
    let handle = file.file.try_clone().map_err(|e| fault(&path, e))?;
    let size = config.scene.size;
    let riff = Riff::begin(handle, (size.width, size.height), config.plays).map_err(|e| fault(&path, e))?;
    Ok(Box::new(Webp { file, riff, delays: Delays::new(config.rate), tone: Tone::of(&config.scene), before: None }))
}

fn fault(path: &Path, reason: impl std::fmt::Display) -> AppError {
    AppError::io("write", path, reason)
}

impl Sink for Webp {
    fn put(&mut self, file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        let picture = display(frame, self.tone);
        let change = Change { picture: &picture, before: self.before.as_ref() };
        let delay = self.delays.next().unwrap_or_default();
        self.riff.put(&change, delay).map_err(|e| fault(file, e))?;
        self.before = Some(picture);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), AppError> {
        let Self { file, riff, .. } = *self;
        riff.finish().map_err(|e| fault(file.target(), e))?;
        Ok(file.finish()?)
    }
}

/// A frame, and the frame that it is shown over.
struct Change<'a> {
    /// The whole picture.
    picture: &'a Rgb8Image,
    /// The picture before it.
    before: Option<&'a Rgb8Image>,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area {
    /// Columns to the left of it.
    x: u32,
    /// Rows above it.
    y: u32,
    /// Pixels across, at least 1.
    width: u32,
    /// Pixels down, at least 1.
    height: u32,
}

impl Change<'_> {
    /// The smallest rectangle that holds all pixels that have changed, with a corner at a multiple of `step`; the pixel in
    /// the corner of the picture if there are none.
    fn area(&self, step: u32) -> Area {
        let (width, height) = (self.picture.width, self.picture.height);
        if self.before.is_none() {
            return Area { x: 0, y: 0, width, height };
        }
        let (mut left, mut right, mut top, mut bottom) = (u32::MAX, 0, u32::MAX, 0);
        for y in 0..height {
            let row = (y * width) as usize..((y + 1) * width) as usize;
            let changed = |index: usize| self.changed(index);
            let Some(first) = row.clone().position(changed) else { continue };
            let last = row.rev().position(changed).map_or(first as u32, |behind| width - 1 - behind as u32);
            (left, right) = (left.min(first as u32), right.max(last));
            (top, bottom) = (top.min(y), y);
        }
        if left > right {
            return Area { x: 0, y: 0, width: 1, height: 1 };
        }
        let (x, y) = (left / step * step, top / step * step);
        Area { x, y, width: right + 1 - x, height: bottom + 1 - y }
    }

    /// Whether a pixel, by its index, is another than before.
    fn changed(&self, index: usize) -> bool {
        self.before.is_none_or(|before| before.texels[index] != self.picture.texels[index])
    }

    /// The indices of the pixels in an area, row by row.
    fn indices(&self, area: Area) -> impl Iterator<Item = usize> + use<> {
        let width = self.picture.width;
        let row = move |y: u32| (area.x..area.x + area.width).map(move |x| (y * width + x) as usize);
        (area.y..area.y + area.height).flat_map(row)
    }

    /// The codes of the pixels in an area, `R, G, B`.
    fn rgb(&self, area: Area) -> Vec<u8> {
        self.indices(area).flat_map(|index| self.picture.texels[index]).collect()
    }
}

/// Delays of frames in milliseconds. What rounding takes from one frame a later one gets back, so the whole is
/// never off by more than half a millisecond.
#[derive(Debug)]
struct Delays {
    rate: Rate,
    frame: u64,
}

impl Delays {
    fn new(rate: Rate) -> Self {
        Self { rate, frame: 0 }
    }

    /// The moment at which a frame begins, rounded.
    fn start(&self, frame: u64) -> u64 {
        let (over, under) = (u128::from(self.rate.numerator()), u128::from(self.rate.denominator()));
        let doubled = 2 * u128::from(frame) * 1000 * under;
        ((doubled + over) / (2 * over)) as u64
    }
}

impl Iterator for Delays {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let start = self.start(self.frame);
        self.frame += 1;
        Some(self.start(self.frame) - start)
    }
}

/// A RIFF file, whose length is filled in at the end.
struct Riff {
    file: File,
    length: u64,
}

/// A chunk: its name, its length, its contents, and a byte if that is odd.
fn chunk(name: &[u8; 4], contents: &[u8]) -> Vec<u8> {
    let mut bytes = [name, &(contents.len() as u32).to_le_bytes()[..], contents].concat();
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// The low three bytes of a number.
fn three(number: u64) -> [u8; 3] {
    let [a, b, c, ..] = number.to_le_bytes();
    [a, b, c]
}

impl Riff {
    fn begin(file: File, (width, height): (u32, u32), plays: u16) -> Result<Self, String> {
        let mut riff = Self { file, length: 0 };
        let flags = [ANIMATION, 0, 0, 0];
        let canvas = [three(u64::from(width) - 1), three(u64::from(height) - 1)];
        let background = [0, 0, 0, 0xff];
        riff.write(b"RIFF\0\0\0\0WEBP")?;
        riff.write(&chunk(b"VP8X", &[&flags[..], canvas.as_flattened()].concat()))?;
        riff.write(&chunk(b"ANIM", &[&background[..], &plays.to_le_bytes()].concat()))?;
        Ok(riff)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.length += bytes.len() as u64;
        // The length in the header does not count itself and what is before it.
        if self.length - 8 > u64::from(u32::MAX) {
            return Err("a WebP has at most 4 GiB; write fewer or smaller frames".to_owned());
        }
        self.file.write_all(bytes).map_err(|e| e.to_string())
    }

    /// Writes what has changed since the frame before, to be shown for `delay` milliseconds.
    fn put(&mut self, change: &Change, delay: u64) -> Result<(), String> {
        // Corners are stored halved.
        let area = change.area(2);
        let mut still = Vec::new();
        let encoder = WebPEncoder::new(&mut still);
        encoder.encode(&change.rgb(area), area.width, area.height, ColorType::Rgb8).map_err(|e| e.to_string())?;
        let picture = still.get(RIFF_HEADER..).filter(|rest| rest.starts_with(b"VP8L"));
        let picture = picture.ok_or("the encoder of WebP returned no lossless picture")?;
        let numbers = [area.x / 2, area.y / 2, area.width - 1, area.height - 1].map(|n| three(n.into()));
        let frame = [numbers.as_flattened(), &three(delay), &[NO_BLENDING], picture].concat();
        self.write(&chunk(b"ANMF", &frame))
    }

    fn finish(mut self) -> Result<(), String> {
        let length = (self.length - 8) as u32;
        let mut fill_in = || {
            self.file.seek(SeekFrom::Start(4))?;
            self.file.write_all(&length.to_le_bytes())
        };
        fill_in().map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_a_change_holds_all_of_it() {
        let picture = |marked: &[usize]| {
            let texels = (0..35).map(|i| if marked.contains(&i) { [9, 0, 0] } else { [1; 3] }).collect();
            Rgb8Image { width: 7, height: 5, texels }
        };
        let before = picture(&[]);
        let area = |marked: &[usize], step| Change { picture: &picture(marked), before: Some(&before) }.area(step);
        let rectangle = |x, y, width, height| Area { x, y, width, height };
        assert_eq!(area(&[], 1), rectangle(0, 0, 1, 1));
        assert_eq!(area(&[10, 26], 1), rectangle(3, 1, 3, 3));
        assert_eq!(area(&[10, 26], 2), rectangle(2, 0, 4, 4));
        assert_eq!(area(&[34], 1), rectangle(6, 4, 1, 1));
        assert_eq!(area(&[0, 34], 2), rectangle(0, 0, 7, 5));
        let first = picture(&[3]);
        let first = Change { picture: &first, before: None };
        assert_eq!(first.area(2), rectangle(0, 0, 7, 5));
        assert_eq!(first.indices(rectangle(5, 1, 2, 2)).collect::<Vec<_>>(), [12, 13, 19, 20]);
        assert_eq!(first.rgb(rectangle(3, 0, 2, 1)), [9, 0, 0, 1, 1, 1]);
    }

    #[test]
    fn rounding_does_not_add_up() {
        for rate in ["24", "30", "30000/1001", "48", "0.7"] {
            let rate: Rate = rate.parse().unwrap();
            let (mut sum, mut shortest, mut longest) = (0, u64::MAX, 0);
            for (count, delay) in (1..=1000).zip(Delays::new(rate)) {
                sum += delay;
                (shortest, longest) = (shortest.min(delay), longest.max(delay));
                let exact = f64::from(count) * 1000.0 / rate.per_second();
                assert!((sum as f64 - exact).abs() <= 0.5 + 1e-9, "{rate:?}: {sum} {exact}");
            }
            assert!(longest - shortest <= 1, "{rate:?}: {shortest} {longest}");
        }
        let second: Vec<_> = Delays::new("24".parse().unwrap()).take(24).collect();
        assert_eq!((second.iter().sum::<u64>(), &second[..6]), (1000, &[42, 41, 42, 42, 41, 42][..]));
    }
}
