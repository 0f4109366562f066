//! A baked map in memory.

use crate::bake::{Kind, Precision};
use crate::moments::{LeadrMap, MomentLevel, Moments};
use crate::{HeightMap, MapFault, Wrap};

/// A baked map. Values exclude the factors of 16-bit files.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMap {
    /// Kind of map.
    pub kind: Kind,
    /// Number format of the file.
    pub precision: Precision,
    /// Channel names: four per layer, `-` if unused.
    pub channels: Vec<String>,
    /// Addressing outside the map.
    pub wrap: Wrap,
    /// Factor on heights.
    pub height_scale: f32,
    /// Unit of heights.
    pub heights: HeightUnit,
    /// Height at the mesh surface: the mean.
    pub middle: f32,
    /// Whether slopes come from a normal map, one per texel of level 0.
    pub of_normals: bool,
    /// Levels from the largest down to 1 x 1.
    pub levels: Vec<BakedLevel>,
}

/// Unit of the heights of a baked map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightUnit {
    /// No heights.
    None,
    /// The unknown unit of the source map.
    Map,
    /// Texture widths.
    Width,
}

/// A level of a baked map.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedLevel {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Per layer, `width * height` row-major texels of four channels.
    pub layers: Vec<Vec<[f32; 4]>>,
}

/// Remedy for files of other programs.
pub(super) const REMEDY: &str = "give a file that leadr bake wrote";

impl BakedMap {
    /// The moments of a LEADR map: those of [`LeadrMap::new`], bit-exact for 32-bit files. `None` for other kinds.
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

    /// Values of the named channel on the finest level, if present.
    pub fn channel(&self, name: &str) -> Option<Vec<f32>> {
        let slot = self.channels.iter().position(|channel| channel == name)?;
        Some(self.levels[0].layers[slot / 4].iter().map(|texel| texel[slot % 4]).collect())
    }

    /// Whether it holds data beyond heights: slopes of normals, roughness or colour.
    pub fn is_material(&self) -> bool {
        self.of_normals || self.channels.iter().any(|name| name == "alpha2" || name == "red")
    }

    /// Checks that surfaces can be drawn with the map: it needs kind LEADR and must repeat.
    ///
    /// # Errors
    /// If the kind is not LEADR, or the map does not repeat.
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

    /// The heights; flat if there are none.
    ///
    /// # Errors
    /// If a height is too large.
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
