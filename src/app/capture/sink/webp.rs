//! Writes lossless animated WebP. The `image-webp` crate encodes the pictures, but does not support the animation container
//! ([specification](https://developers.google.com/speed/webp/docs/riff_container)), which this module writes.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use image_webp::{ColorType, WebPEncoder};

use super::Sink;
use super::comparison::TechniqueErrors;
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::save::display;
use crate::app::flags::values::Rate;
use leadr_maps::Rgb8Image;
use leadr_maps::new_file::NewFile;
use leadr_maps::origin::Origin;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;

/// The size of the RIFF header in bytes: `RIFF`, a length, and `WEBP`.
const RIFF_HEADER: usize = 12;

/// The flag of a file that marks an animation.
const ANIMATION: u8 = 1 << 1;

/// The flag of a frame that replaces pixels without blending.
const NO_BLENDING: u8 = 1 << 1;

/// Appends frames to a RIFF file and fills in its length at the end. Only the previous picture is kept in memory.
pub struct Webp<'a> {
    config: &'a CaptureConfig,
    file: NewFile,
    length: u64,
    frames: u64,
    before: Option<Rgb8Image>,
}

impl<'a> Webp<'a> {
    pub fn begin(config: &'a CaptureConfig) -> Result<Self, AppError> {
        let mut webp = Self { config, file: begin(&config.output.path(0))?, length: 0, frames: 0, before: None };
        let Size { width, height } = config.scene.size;
        let flags = [ANIMATION, 0, 0, 0];
        let canvas = [three(u64::from(width) - 1), three(u64::from(height) - 1)];
        let background = [0, 0, 0, 0xff];
        webp.write(b"RIFF\0\0\0\0WEBP")?;
        webp.write(&chunk(b"VP8X", &[&flags[..], canvas.as_flattened()].concat()))?;
        webp.write(&chunk(b"ANIM", &[&background[..], &config.plays.to_le_bytes()].concat()))?;
        Ok(webp)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), AppError> {
        self.length += bytes.len() as u64;
        // The length in the header does not include the length field itself and the four bytes before it.
        if self.length - 8 > u64::from(u32::MAX) {
            return Err(self.fault("a WebP holds at most 4 GiB: write fewer or smaller frames"));
        }
        self.file.file.write_all(bytes).map_err(|error| self.fault(error))
    }

    fn fault(&self, reason: impl std::fmt::Display) -> AppError {
        AppError::io("write", self.file.target(), reason)
    }
}

impl Sink for Webp<'_> {
    /// Writes the rectangle that changed since the previous frame.
    fn put(&mut self, _file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        let picture = display(frame, &self.config.scene.picture);
        let whole = Area { x: 0, y: 0, width: picture.width, height: picture.height };
        let area = self.before.as_ref().map_or(whole, |before| changed_area(before, &picture));
        let delay = begins(self.config.rate, self.frames + 1) - begins(self.config.rate, self.frames);
        self.frames += 1;
        let mut still = Vec::new();
        WebPEncoder::new(&mut still)
            .encode(&rgb_in(&picture, area), area.width, area.height, ColorType::Rgb8)
            .map_err(|error| self.fault(error))?;
        let lossless = still.get(RIFF_HEADER..).filter(|rest| rest.starts_with(b"VP8L"));
        let lossless = lossless.ok_or_else(|| self.fault("the WebP encoder returned no lossless image"))?;
        // The format stores the corner coordinates divided by two.
        let numbers = [area.x / 2, area.y / 2, area.width - 1, area.height - 1].map(|n| three(n.into()));
        let frame = [numbers.as_flattened(), &three(delay), &[NO_BLENDING], lossless].concat();
        self.write(&chunk(b"ANMF", &frame))?;
        self.before = Some(picture);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError> {
        let length = (self.length - 8) as u32;
        let file = &mut self.file.file;
        let filled_in = file.seek(SeekFrom::Start(4)).and_then(|_| file.write_all(&length.to_le_bytes()));
        filled_in.map_err(|error| self.fault(error))?;
        self.file.finish()?;
        Ok(Vec::new())
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area {
    /// Left column.
    x: u32,
    /// Top row.
    y: u32,
    /// The width in pixels, at least 1.
    width: u32,
    /// The height in pixels, at least 1.
    height: u32,
}

/// Returns the smallest rectangle with an even corner that contains all changed pixels. If no pixel has changed, it is the top left pixel.
fn changed_area(before: &Rgb8Image, picture: &Rgb8Image) -> Area {
    let (mut left, mut right, mut top, mut bottom) = (u32::MAX, 0, u32::MAX, 0);
    for (index, (old, new)) in before.texels.iter().zip(&picture.texels).enumerate() {
        if old != new {
            let (x, y) = (index as u32 % picture.width, index as u32 / picture.width);
            (left, right) = (left.min(x), right.max(x));
            (top, bottom) = (top.min(y), y);
        }
    }
    if left > right {
        return Area { x: 0, y: 0, width: 1, height: 1 };
    }
    let (x, y) = (left / 2 * 2, top / 2 * 2);
    Area { x, y, width: right + 1 - x, height: bottom + 1 - y }
}

/// Returns the `R, G, B` codes of the pixels in an area.
fn rgb_in(picture: &Rgb8Image, area: Area) -> Vec<u8> {
    let columns = area.x as usize..(area.x + area.width) as usize;
    let rows = picture.texels.chunks(picture.width as usize).skip(area.y as usize).take(area.height as usize);
    rows.flat_map(|row| row[columns.clone()].as_flattened()).copied().collect()
}

/// Returns the start time of a frame in milliseconds. Start times are rounded instead of delays, so that rounding errors do not add up.
fn begins(rate: Rate, frame: u64) -> u64 {
    let (over, under) = (u128::from(rate.numerator()), u128::from(rate.denominator()));
    let doubled = 2 * u128::from(frame) * 1000 * under;
    ((doubled + over) / (2 * over)) as u64
}

/// Builds a RIFF chunk: the name, the length, and the contents, padded to an even length.
fn chunk(name: &[u8; 4], contents: &[u8]) -> Vec<u8> {
    let mut bytes = [name, &(contents.len() as u32).to_le_bytes()[..], contents].concat();
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// Returns the low three bytes of a number.
fn three(number: u64) -> [u8; 3] {
    let [a, b, c, ..] = number.to_le_bytes();
    [a, b, c]
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
        let area = |marked: &[usize]| changed_area(&picture(&[]), &picture(marked));
        let rectangle = |x, y, width, height| Area { x, y, width, height };
        assert_eq!(area(&[]), rectangle(0, 0, 1, 1));
        assert_eq!(area(&[10, 26]), rectangle(2, 0, 4, 4));
        assert_eq!(area(&[19]), rectangle(4, 2, 2, 1));
        assert_eq!(area(&[34]), rectangle(6, 4, 1, 1));
        assert_eq!(area(&[0, 34]), rectangle(0, 0, 7, 5));
        assert_eq!(rgb_in(&picture(&[3]), rectangle(3, 0, 2, 1)), [9, 0, 0, 1, 1, 1]);
        assert_eq!(rgb_in(&picture(&[12, 20]), rectangle(5, 1, 2, 2)), [9, 0, 0, 1, 1, 1, 1, 1, 1, 9, 0, 0]);
    }

    #[test]
    fn rounding_does_not_add_up() {
        for rate in ["24", "30", "30000/1001", "48", "0.7"] {
            let rate: Rate = rate.parse().unwrap();
            let delays: Vec<u64> = (0..1000).map(|frame| begins(rate, frame + 1) - begins(rate, frame)).collect();
            for frame in 0..=1000 {
                let exact = frame as f64 * 1000.0 / rate.per_second();
                assert!((begins(rate, frame) as f64 - exact).abs() <= 0.5 + 1e-9, "{rate:?}: {frame} {exact}");
            }
            let (shortest, longest) = (delays.iter().min().unwrap(), delays.iter().max().unwrap());
            assert!(longest - shortest <= 1, "{rate:?}: {shortest} {longest}");
        }
        let moments: Vec<u64> = [0, 1, 2, 3, 4, 24].map(|frame| begins("24".parse().unwrap(), frame)).to_vec();
        assert_eq!(moments, [0, 42, 83, 125, 167, 1000]);
    }
}
