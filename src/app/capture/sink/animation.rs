//! A moving picture: what its formats have in common.

use std::fs::File;
use std::path::Path;

use super::delays::Delays;
use super::frame_sink::Sink;
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::save::{Tone, display};
use crate::app::flags::values::Rate;
use leadr_maps::Rgb8Image;
use leadr_maps::new_file::NewFile;
use leadr_maps::origin::Origin;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;

/// What an encoder is told before the first frame.
#[derive(Clone, Copy, Debug)]
pub struct Header {
    /// Pixels of the picture.
    pub size: Size,
    /// Number of frames.
    pub frames: u32,
    /// How often the frames are shown; 0 is without end.
    pub plays: u16,
    /// Frames per second.
    pub rate: Rate,
}

/// A format of moving pictures.
pub trait Encoder: Sized {
    /// Begins a file.
    fn begin(file: File, header: &Header) -> Result<Self, String>;

    /// Units of a delay in a second.
    fn units(header: &Header) -> u32;

    /// Writes what has changed since the frame before, to be shown for `delay` units.
    fn put(&mut self, change: &Change, delay: u64) -> Result<(), String>;

    /// Writes the end.
    fn finish(self) -> Result<(), String>;
}

/// A frame, and the frame that it is shown over.
pub struct Change<'a> {
    /// The whole picture.
    pub picture: &'a Rgb8Image,
    /// The picture before it.
    pub before: Option<&'a Rgb8Image>,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// Columns to the left of it.
    pub x: u32,
    /// Rows above it.
    pub y: u32,
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Change<'_> {
    /// The smallest rectangle that holds all pixels that have changed, with a corner at a multiple of `step`; the pixel in
    /// the corner of the picture if there are none.
    pub fn area(&self, step: u32) -> Area {
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
    pub fn changed(&self, index: usize) -> bool {
        self.before.is_none_or(|before| before.texels[index] != self.picture.texels[index])
    }

    /// The indices of the pixels in an area, row by row.
    pub fn indices(&self, area: Area) -> impl Iterator<Item = usize> + use<> {
        let width = self.picture.width;
        let row = move |y: u32| (area.x..area.x + area.width).map(move |x| (y * width + x) as usize);
        (area.y..area.y + area.height).flat_map(row)
    }

    /// The codes of the pixels in an area, `R, G, B`.
    pub fn rgb(&self, area: Area) -> Vec<u8> {
        self.indices(area).flat_map(|index| self.picture.texels[index]).collect()
    }
}

/// Writes frames into one file as they come: what it holds of them is the last one.
struct Animation<E> {
    file: NewFile,
    encoder: E,
    delays: Delays,
    tone: Tone,
    before: Option<Rgb8Image>,
}

/// Begins the moving picture that `config` asks for.
pub fn open<E: Encoder + 'static>(config: &CaptureConfig) -> Result<Box<dyn Sink>, AppError> {
    let path = config.output.path(0);
    let file = begin(&path)?;
    let header = Header {
        size: config.scene.size,
        frames: config.moments().len() as u32,
        plays: config.plays,
        rate: config.rate,
    };
    let handle = file.file.try_clone().map_err(|e| fault(&path, e))?;
    let encoder = E::begin(handle, &header).map_err(|e| fault(&path, e))?;
    let delays = Delays::new(header.rate, E::units(&header));
    Ok(Box::new(Animation { file, encoder, delays, tone: Tone::of(&config.scene), before: None }))
}

fn fault(path: &Path, reason: impl std::fmt::Display) -> AppError {
    AppError::io("write", path, reason)
}

impl<E: Encoder> Sink for Animation<E> {
    fn put(&mut self, file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        let picture = display(frame, self.tone);
        let change = Change { picture: &picture, before: self.before.as_ref() };
        let delay = self.delays.next().unwrap_or_default();
        self.encoder.put(&change, delay).map_err(|e| fault(file, e))?;
        self.before = Some(picture);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), AppError> {
        let Self { file, encoder, .. } = *self;
        encoder.finish().map_err(|e| fault(file.target(), e))?;
        Ok(file.finish()?)
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
}
