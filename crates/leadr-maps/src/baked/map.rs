//! A baked map in memory.

use rayon::prelude::*;

use crate::bake::{CLASS_CHANNELS, Kind, Precision};
use crate::derive::Openness;
use crate::halves::half;
use crate::moments::{LeadrMap, MomentLevel, Moments};
use crate::{ClassFrame, ClassLevel, ClassMap, HeightMap, MapFault, Wrap};

/// A baked map in memory. The values are already divided by the factors of 16-bit files.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMap {
    /// The kind of map.
    pub kind: Kind,
    /// The number format of the file.
    pub precision: Precision,
    /// The channel names, four per layer. Unused channels are named `-`.
    pub channels: Vec<String>,
    /// How texels outside the map are addressed.
    pub wrap: Wrap,
    /// The factor that was applied to the input heights.
    pub height_scale: f32,
    /// The unit of the heights.
    pub heights: HeightUnit,
    /// The height that lies at the mesh surface, which is the mean height.
    pub middle: f32,
    /// Whether the slopes come from a normal map, which gives one slope per texel of the source.
    pub of_normals: bool,
    /// The number of finest levels that the file leaves out. The texels of its finest level then contain several slopes.
    pub dropped_levels: u32,
    /// The centres and units of the classes, if the map has several.
    pub classes: Option<ClassFrame>,
    /// The openness of the classes. Files of earlier versions lack it.
    pub openness: Option<Openness>,
    /// The mip levels, from the largest to the level of 1 x 1 texels.
    pub levels: Vec<BakedLevel>,
}

/// The unit of the heights of a baked map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightUnit {
    /// The map has no heights.
    None,
    /// The unit of the source map, whose length is unknown.
    Map,
    /// The unit is the texture width.
    Width,
}

/// A mip level of a baked map.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedLevel {
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// The row-major texels of each layer. A layer has `width * height` texels of four channels.
    pub layers: Vec<Vec<[f32; 4]>>,
}

/// The remedy in error messages about files that another program wrote.
pub(super) const REMEDY: &str = "give a file that leadr bake wrote";

impl BakedMap {
    /// Returns the moments of a LEADR map, or `None` for other kinds. If the file stores 32-bit floats, the moments equal
    /// those of [`LeadrMap::new`] to the last bit.
    pub fn moments(&self) -> Option<LeadrMap> {
        let leadr = self.kind == Kind::Leadr;
        leadr.then(|| LeadrMap { levels: self.levels.iter().map(BakedLevel::moments).collect() })
    }

    /// Like [`moments`](Self::moments), but frees each level after its conversion.
    #[must_use]
    pub fn into_moments(self) -> Option<LeadrMap> {
        let leadr = self.kind == Kind::Leadr;
        leadr.then(|| LeadrMap { levels: self.levels.into_iter().map(|level| level.moments()).collect() })
    }

    /// Returns the moments of the classes, or `None` if the file has none. Shares are limited to 0 to 1.
    pub fn class_map(&self) -> Option<ClassMap> {
        let ClassFrame { centers, units } = self.classes.clone()?;
        let slot = |name: &&str| self.channels.iter().position(|channel| channel == name);
        let slots: Vec<usize> =
            CLASS_CHANNELS[..centers.len()].as_flattened().iter().map(slot).collect::<Option<_>>()?;
        let level = |level: &BakedLevel| {
            let layer = |(i, slots): (usize, &[usize; 4])| {
                let texel = |at: usize| {
                    let value = |slot: usize| level.layers[slot / 4][at][slot % 4];
                    let [w, x, y, z] = slots.map(value);
                    [if i % 2 == 0 { w.clamp(0.0, 1.0) } else { w }, x, y, z].map(half)
                };
                (0..level.layers[0].len()).into_par_iter().map(texel).collect()
            };
            let layers = slots.as_chunks().0.iter().enumerate().map(layer).collect();
            ClassLevel { width: level.width, height: level.height, layers }
        };
        let levels = self.levels.iter().map(level).collect();
        Some(ClassMap { centers, units, levels })
    }

    /// Returns the values of the named channel on the finest level, or `None` if the map has no such channel.
    pub fn channel(&self, name: &str) -> Option<Vec<f32>> {
        let slot = self.channels.iter().position(|channel| channel == name)?;
        Some(self.levels[0].layers[slot / 4].iter().map(|texel| texel[slot % 4]).collect())
    }

    /// Whether the map holds more than heights, such as slopes from normals, roughness or colour.
    pub fn is_material(&self) -> bool {
        self.of_normals || self.channels.iter().any(|name| name == "alpha2" || name == "red")
    }

    /// Checks that a surface can be drawn with the map.
    ///
    /// # Errors
    /// Fails if the kind is not LEADR, or the map does not repeat.
    pub fn check_drawable(&self) -> Result<(), MapFault> {
        if self.kind != Kind::Leadr {
            let what = format!("it holds a map of kind {}, which cannot be drawn", self.kind.name());
            return Err(MapFault::unsupported(what, "bake it with --kind leadr"));
        }
        if self.wrap == Wrap::Clamp {
            let what = "it was baked with --wrap clamp, but maps must repeat";
            return Err(MapFault::unsupported(what, "bake it with --wrap repeat"));
        }
        Ok(())
    }

    /// Returns the height map, which is flat if the file has no heights.
    ///
    /// # Errors
    /// Fails if a height exceeds the limit.
    pub fn height_map(&self) -> Result<HeightMap, MapFault> {
        let BakedLevel { width, height, .. } = self.levels[0];
        let texels = self.channel("height").unwrap_or_else(|| vec![0.0; width as usize * height as usize]);
        HeightMap::new(width, height, texels)
    }
}

impl BakedLevel {
    /// Returns the moments of a level of a LEADR map. Panics for other kinds.
    pub fn moments(&self) -> MomentLevel {
        let texel = |(&[x, y, xx, yy], &[cross, height, ..]): (&[f32; 4], &[f32; 4])| Moments {
            mean_slope: [x, y],
            second: [xx, yy],
            cross,
            height,
        };
        let texels = self.layers[0].iter().zip(&self.layers[1]).map(texel).collect();
        MomentLevel { width: self.width, height: self.height, texels }
    }
}
