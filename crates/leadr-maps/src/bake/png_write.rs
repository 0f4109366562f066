//! 16-bit PNG writer for the finest level of the file, without mip levels. Artists can view and paint the file.

use std::fs::File;
use std::io::Write;

use image::ExtendedColorType;

use super::{Kind, Plan, Report, Target};
use crate::save::encode_png;
use crate::{MapFault, limits};

/// A PNG file in preparation.
pub struct PngFile<'a> {
    plan: &'a Plan,
    size: [u32; 2],
    texels: Vec<f32>,
}

impl<'a> PngFile<'a> {
    /// Whether a PNG can store maps of this kind.
    pub const fn holds(kind: Kind) -> bool {
        !kind.stores_variance()
    }

    /// Allocates the texels.
    ///
    /// # Errors
    /// Fails if memory runs out.
    pub fn new(plan: &'a Plan) -> Result<Self, MapFault> {
        let size = plan.level_sizes()[0];
        let texels = size[0] as usize * size[1] as usize;
        Ok(Self { plan, size, texels: limits::zeroed(texels * plan.kind.channels().len())? })
    }

    /// Writes the file. Heights use the full code range, whose limits are in [`Report::height_range`]. Directions map -1..1
    /// to the code range, and other values map 0..1.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn finish(self, file: &mut File, report: &Report) -> Result<(), MapFault> {
        let channels = self.plan.kind.channels();
        let [low, high] = report.height_range;
        let range = |name: &str| match name {
            "height" => [low, if high > low { high } else { low + 1.0 }],
            name if name.starts_with("N.") || name.starts_with("C.") => [-1.0, 1.0],
            _ => [0.0, 1.0],
        };
        let ranges: Vec<[f64; 2]> = channels.iter().map(|name| range(name)).collect();
        let code = |(i, &value): (usize, &f32)| {
            let [low, high] = ranges[i % channels.len()];
            // The cast from float to integer saturates.
            ((f64::from(value) - low) / (high - low) * 65535.0).round() as u16
        };
        let samples: Vec<u8> = self.texels.iter().enumerate().flat_map(|texel| code(texel).to_ne_bytes()).collect();
        let color = match channels.len() {
            1 => ExtendedColorType::L16,
            3 => ExtendedColorType::Rgb16,
            _ => ExtendedColorType::Rgba16,
        };
        let bytes = encode_png(&samples, self.size, color)?;
        file.write_all(&bytes).map_err(MapFault::io("cannot be written"))
    }
}

impl Target for PngFile<'_> {
    fn rows(&mut self, level: usize, first: u32, rows: &[Vec<f32>]) -> Result<(), MapFault> {
        if level > 0 {
            return Ok(());
        }
        let (all, kept) = (self.plan.channels.len(), self.plan.kind.channels().len());
        let width = self.size[0] as usize;
        let start = first as usize * width * kept;
        let from = rows.iter().flat_map(|row| row.chunks_exact(all).flat_map(|texel| &texel[..kept]));
        self.texels[start..].iter_mut().zip(from).for_each(|(to, v)| *to = *v);
        Ok(())
    }
}
