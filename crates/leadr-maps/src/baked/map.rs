//! What a baked map holds, once it is read.

use crate::bake::{Kind, Precision};
use crate::moments::{LeadrMap, MomentLevel, Moments};
use crate::{HeightMap, MapFault, Wrap};

/// A baked map. Values are as they were before the factors of 16-bit files were put on them.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMap {
    /// How slopes are kept.
    pub kind: Kind,
    /// Width of the numbers in the file.
    pub precision: Precision,
    /// Names of the channels: four for each layer, `-` for one that is not used.
    pub channels: Vec<String>,
    /// What lies beyond the edges.
    pub wrap: Wrap,
    /// Factor that heights were multiplied by.
    pub height_scale: f32,
    /// What heights are measured in.
    pub heights: HeightUnit,
    /// The height that lies on the mesh: the mean.
    pub middle: f32,
    /// Whether slopes are those of a normal map, one for a texel of level 0.
    pub of_normals: bool,
    /// The levels, the largest first, down to 1 x 1.
    pub levels: Vec<BakedLevel>,
}

/// What the heights of a baked map are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightUnit {
    /// There are none.
    None,
    /// The unit of the map that they were read from, which nothing tells.
    Map,
    /// Widths of the texture.
    Width,
}

/// A level of a baked map.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedLevel {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// For each layer `width * height` texels of four channels, row-major.
    pub layers: Vec<Vec<[f32; 4]>>,
}

/// What is said of files that others made.
pub(super) const REMEDY: &str = "give a file that leadr bake wrote";

impl BakedMap {
    /// The moments of a LEADR map: those of [`LeadrMap::new`], to the last bit if the file has 32 bits. `None` for other kinds.
    pub fn moments(&self) -> Option<LeadrMap> {
        let leadr = self.kind == Kind::Leadr;
        leadr.then(|| LeadrMap { levels: self.levels.iter().map(BakedLevel::moments).collect() })
    }

    /// The same, each level in place of what it is made of.
    #[must_use]
    pub fn into_moments(self) -> Option<LeadrMap> {
        let leadr = self.kind == Kind::Leadr;
        leadr.then(|| LeadrMap { levels: self.levels.into_iter().map(|level| level.moments()).collect() })
    }

    /// The values of a channel on the finest level, if it has one of this name.
    pub fn channel(&self, name: &str) -> Option<Vec<f32>> {
        let slot = self.channels.iter().position(|channel| channel == name)?;
        Some(self.levels[0].layers[slot / 4].iter().map(|texel| texel[slot % 4]).collect())
    }

    /// Whether it holds more than what follows from heights: slopes of normals, roughness, colour.
    pub fn is_material(&self) -> bool {
        self.of_normals || self.channels.iter().any(|name| name == "alpha2" || name == "red")
    }

    /// Checks that surfaces can be drawn with it: moments of slopes, on a map that repeats.
    ///
    /// # Errors
    /// What it is instead.
    pub fn check_drawable(&self) -> Result<(), MapFault> {
        if self.kind != Kind::Leadr {
            let what = format!("it holds a map of kind {}, from which surfaces are not drawn here", self.kind.name());
            return Err(MapFault::unsupported(what, "bake it with --kind leadr"));
        }
        if self.wrap == Wrap::Clamp {
            let what = "it was baked with --wrap clamp, and maps repeat here";
            return Err(MapFault::unsupported(what, "bake it with --wrap repeat"));
        }
        Ok(())
    }

    /// Its heights; flat where it has none.
    ///
    /// # Errors
    /// If one is too large.
    pub fn height_map(&self) -> Result<HeightMap, MapFault> {
        let BakedLevel { width, height, .. } = self.levels[0];
        let texels = self.channel("height").unwrap_or_else(|| vec![0.0; width as usize * height as usize]);
        HeightMap::new(width, height, texels)
    }
}

impl BakedLevel {
    fn moments(&self) -> MomentLevel {
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
