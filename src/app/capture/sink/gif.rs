//! Animated GIF: 255 colours a frame, dithered, and one that lets the frame before show through.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufWriter, Write};

use gif::{DisposalMethod, EncodingError, Frame, Repeat};

use super::animation::{Change, Encoder, Header};
use super::palette::Palette;

/// Writes a GIF.
pub struct Gif {
    encoder: gif::Encoder<BufWriter<File>>,
}

fn open(file: File, header: &Header) -> Result<gif::Encoder<BufWriter<File>>, EncodingError> {
    // A side of a picture is at most 2¹⁴.
    let (width, height) = (header.size.width as u16, header.size.height as u16);
    let mut encoder = gif::Encoder::new(BufWriter::new(file), width, height, &[])?;
    match header.plays {
        0 => encoder.set_repeat(Repeat::Infinite)?,
        1 => (),
        // The format counts what follows the first time.
        plays => encoder.set_repeat(Repeat::Finite(plays - 1))?,
    }
    Ok(encoder)
}

impl Encoder for Gif {
    fn begin(file: File, header: &Header) -> Result<Self, String> {
        Ok(Self { encoder: open(file, header).map_err(|e| e.to_string())? })
    }

    fn units(_: &Header) -> u32 {
        100
    }

    fn put(&mut self, change: &Change, delay: u64) -> Result<(), String> {
        let area = change.area(1);
        // Pixels that have not changed are left as they were dithered: what stands still does not flicker.
        let pixels: Vec<_> =
            change.indices(area).map(|i| change.changed(i).then(|| change.picture.texels[i])).collect();
        let mut palette = Palette::of(&pixels);
        let frame = Frame {
            delay: u16::try_from(delay).map_err(|_| "a frame is shown for too long")?,
            dispose: DisposalMethod::Keep,
            transparent: change.before.map(|_| palette.transparent()),
            top: area.y as u16,
            left: area.x as u16,
            width: area.width as u16,
            height: area.height as u16,
            buffer: Cow::Owned(palette.dither(&pixels, area.width as usize)),
            palette: Some(palette.table()),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(|e| e.to_string())
    }

    fn finish(self) -> Result<(), String> {
        let mut rest = self.encoder.into_inner().map_err(|e| e.to_string())?;
        rest.flush().map_err(|e| e.to_string())
    }
}
