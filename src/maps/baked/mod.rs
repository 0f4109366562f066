//! Baked maps read back, level by level, from KTX2 or EXR, with nothing believed that the file is too short to hold.

mod exr;
mod keys;
mod ktx2;

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::bake::{Kind, Precision};
use super::guard::guarded;
use super::moments::{LeadrMap, MomentLevel, Moments};
use super::{HeightMap, MapError, MapFault, Wrap, exr_read, limits};

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
const REMEDY: &str = "give a file that leadr bake wrote";

/// Whether a file is, by its content, one that `leadr bake` may have written: any KTX2, or an EXR that names a kind.
///
/// # Errors
/// If it cannot be read.
pub fn is_baked(path: impl AsRef<Path>) -> Result<bool, MapError> {
    // An EXR says it in its header.
    let start = open(path.as_ref()).and_then(|(file, _)| start(&file, 1 << 16));
    let start = start.map_err(|fault| fault.in_file(path.as_ref()))?;
    Ok(start.starts_with(&::ktx2::MAGIC) || exr_read::is_exr(&start) && contains(&start, b"leadr.kind\0string\0"))
}

/// A regular file, and its length.
fn open(path: &Path) -> Result<(File, u64), MapFault> {
    let io = |doing| move |source| MapFault::Io { doing, source };
    // Asked before opening: opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(io("cannot be found"))?;
    if !metadata.is_file() {
        return Err(MapFault::NotAFile);
    }
    Ok((File::open(path).map_err(io("cannot be opened"))?, metadata.len()))
}

/// Its first bytes.
fn start(file: &File, most: u64) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    let read = file.take(most).read_to_end(&mut bytes);
    read.map_err(|source| MapFault::Io { doing: "cannot be read", source })?;
    Ok(bytes)
}

fn contains(bytes: &[u8], wanted: &[u8]) -> bool {
    bytes.windows(wanted.len()).any(|window| window == wanted)
}

impl BakedMap {
    /// Reads a file that `leadr bake` wrote.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, is a picture of another kind, or holds a number that is not finite (its place is named).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MapError> {
        let path = path.as_ref();
        let read = || {
            let (file, length) = open(path)?;
            if exr_read::is_exr(&start(&file, 4)?) {
                return exr::read(&limits::read_file(path)?);
            }
            guarded("KTX2", || ktx2::read(&mut BufReader::new(file), length))
        };
        read().map_err(|fault| fault.in_file(path))
    }

    /// Reads it from memory; as [`load`](Self::load).
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn decode(bytes: &[u8]) -> Result<Self, MapFault> {
        if exr_read::is_exr(bytes) {
            return exr::read(bytes);
        }
        guarded("KTX2", || ktx2::read(&mut std::io::Cursor::new(bytes), bytes.len() as u64))
    }

    /// The moments of a LEADR map: those of [`LeadrMap::new`], to the last bit if the file has 32 bits. `None` for other kinds.
    #[must_use]
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
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<Vec<f32>> {
        let slot = self.channels.iter().position(|channel| channel == name)?;
        Some(self.levels[0].layers[slot / 4].iter().map(|texel| texel[slot % 4]).collect())
    }

    /// Whether it holds more than what follows from heights: slopes of normals, roughness, colour.
    #[must_use]
    pub fn is_material(&self) -> bool {
        self.of_normals || self.channels.iter().any(|name| name == "alpha2" || name == "red")
    }

    /// Checks that surfaces can be drawn with it: moments of slopes, on a map that repeats.
    ///
    /// # Errors
    /// What it is instead.
    pub fn check_drawable(&self) -> Result<(), MapFault> {
        let refuse = |what: String, remedy: &str| Err(MapFault::Unsupported { what, remedy: remedy.into() });
        if self.kind != Kind::Leadr {
            let what = format!("it holds a map of kind {}, from which surfaces are not drawn here", self.kind.name());
            return refuse(what, "bake it with --kind leadr");
        }
        if self.wrap == Wrap::Clamp {
            return refuse("it was baked with --wrap clamp, and maps repeat here".into(), "bake it with --wrap repeat");
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
