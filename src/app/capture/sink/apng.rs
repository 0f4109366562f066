//! Animated PNG.

use std::fs::File;
use std::io::BufWriter;

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, EncodingError, Writer};

use super::animation::{Change, Encoder, Header};

/// Writes a PNG whose first frame is what programs show that know no animation.
pub struct Apng {
    writer: Writer<BufWriter<File>>,
    units: u16,
}

impl Apng {
    fn write(&mut self, change: &Change, delay: u16) -> Result<(), EncodingError> {
        let area = change.area(1);
        // Position and size are checked together.
        self.writer.reset_frame_position()?;
        self.writer.set_frame_dimension(area.width, area.height)?;
        self.writer.set_frame_position(area.x, area.y)?;
        self.writer.set_frame_delay(delay, self.units)?;
        self.writer.write_image_data(&change.rgb(area))
    }
}

fn open(file: File, header: &Header) -> Result<Writer<BufWriter<File>>, EncodingError> {
    let mut encoder = png::Encoder::new(BufWriter::new(file), header.size.width, header.size.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(header.frames, header.plays.into())?;
    encoder.set_blend_op(BlendOp::Source)?;
    encoder.set_dispose_op(DisposeOp::None)?;
    encoder.write_header()
}

impl Encoder for Apng {
    fn begin(file: File, header: &Header) -> Result<Self, String> {
        let writer = open(file, header).map_err(|e| e.to_string())?;
        Ok(Self { writer, units: Self::units(header) as u16 })
    }

    /// Delays are fractions, so most rates are exact: a delay is the denominator of the rate in units of its numerator.
    fn units(header: &Header) -> u32 {
        let (numerator, denominator) = (header.rate.numerator(), header.rate.denominator());
        if numerator.max(denominator) <= u32::from(u16::MAX) { numerator } else { 1000 }
    }

    fn put(&mut self, change: &Change, delay: u64) -> Result<(), String> {
        let delay = u16::try_from(delay).map_err(|_| "a frame is shown for too long")?;
        self.write(change, delay).map_err(|e| e.to_string())
    }

    fn finish(self) -> Result<(), String> {
        self.writer.finish().map_err(|e| e.to_string())
    }
}
