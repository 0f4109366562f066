//! EXR writer with mip levels. Tiles have 64 x 64 texels, level sizes are rounded down, and each channel of the plan becomes
//! one EXR channel.
//!
//! The whole result stays in memory until it is written. The format stores the largest level first, and the `exr` crate
//! takes only a complete image.

use std::fs::File;
use std::io::BufWriter;

use exr::image::Levels;
use exr::math::RoundingMode;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Text, Vec2, WritableImage,
};
use half::f16;

use super::keys::keys;
use super::{Layout, Plan, Precision, Report, Target};
use crate::fault::one_line;
use crate::{MapFault, Wrap, limits};

/// An EXR file in preparation.
pub struct ExrFile<'a> {
    plan: &'a Plan,
    sizes: Vec<[u32; 2]>,
    planes: Vec<Vec<FlatSamples>>,
}

impl<'a> ExrFile<'a> {
    /// Allocates the samples.
    ///
    /// # Errors
    /// Fails if memory runs out.
    pub fn new(plan: &'a Plan) -> Result<Self, MapFault> {
        let sizes = plan.level_sizes();
        let plane = |&[w, h]: &[u32; 2]| {
            let texels = w as usize * h as usize;
            Ok(match plan.precision {
                Precision::F32 => FlatSamples::F32(limits::zeroed(texels)?),
                Precision::F16 => FlatSamples::F16(limits::zeroed(texels)?),
                Precision::Bc => return Err(MapFault::unsupported("an EXR cannot hold blocks", "write a .ktx2 file")),
            })
        };
        let planes =
            plan.channels.iter().map(|_| sizes.iter().map(plane).collect()).collect::<Result<_, MapFault>>()?;
        Ok(Self { plan, sizes, planes })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn finish(self, file: &mut File, report: &Report) -> Result<(), MapFault> {
        let Self { plan, sizes, planes } = self;
        let mut channels = SmallVec::new();
        for (name, level_data) in plan.channels.iter().zip(planes) {
            let levels = Levels::Mip { rounding_mode: RoundingMode::Down, level_data };
            channels.push(AnyChannel::new(Text::from(*name), levels));
        }
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::Tiles(Vec2(64, 64)),
            line_order: LineOrder::Increasing,
        };
        let size = Vec2(sizes[0][0] as usize, sizes[0][1] as usize);
        let mut attributes = LayerAttributes::default();
        let mut say = |key: &str, value: String| {
            attributes.other.insert(Text::from(key), AttributeValue::Text(Text::from(value.as_str())));
        };
        let wrap = if plan.wrap == Wrap::Repeat { "periodic,periodic" } else { "clamp,clamp" };
        if plan.layout == Layout::Oiio {
            say("textureformat", "Plain Texture".to_owned());
        } else {
            let slots: Vec<Option<usize>> = (0..plan.channels.len()).map(Some).collect();
            keys(plan, &slots, Some(report)).into_iter().for_each(|(key, value)| say(key, value));
        }
        attributes.wrap_mode_name = Some(Text::from(wrap));
        let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels));
        let written = Image::from_layer(layer).write().to_buffered(BufWriter::new(file));
        written.map_err(|error| match error {
            exr::error::Error::Io(source) => MapFault::io("cannot be written")(source),
            other => MapFault::unsupported(one_line(&other), "write a .ktx2 file"),
        })
    }
}

impl Target for ExrFile<'_> {
    fn rows(&mut self, level: usize, first: u32, rows: &[Vec<f32>]) -> Result<(), MapFault> {
        let width = self.sizes[level][0] as usize;
        let channels = self.plan.channels.len();
        for (channel, levels) in self.planes.iter_mut().enumerate() {
            let values = rows.iter().flat_map(|row| row[channel..].iter().step_by(channels));
            let start = first as usize * width;
            match &mut levels[level] {
                FlatSamples::F32(plane) => plane[start..].iter_mut().zip(values).for_each(|(texel, v)| *texel = *v),
                FlatSamples::F16(plane) => {
                    plane[start..].iter_mut().zip(values).for_each(|(texel, v)| *texel = f16::from_f32(*v));
                }
                FlatSamples::U32(_) => unreachable!("planes are floats"),
            }
        }
        Ok(())
    }
}
