//! UDIM tiles: one image for each unit square of texture coordinates, numbered `1001 + u + 10 v`. The tiles are read as one image,
//! the atlas.

use std::path::{Path, PathBuf};

use super::folders::matching;
use super::material::{Raster, Samples};
use super::{HeightMap, MapError, MapFault, limits};
use crate::shown::shown_path;

/// The number of the first tile.
const FIRST: u32 = 1001;
/// The number of columns of tiles.
const COLUMNS: u32 = 10;
/// The word in a file name that stands for the number of a tile.
const WORD: &str = "<UDIM>";
/// The number of missing tiles that a remark names.
const MOST_NAMED: usize = 8;

/// The files of a map that is split into tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// The number of tiles across and up.
    pub grid: [u32; 2],
    /// The files in ascending order, each with the column and the row of its tile, from the lower left.
    files: Vec<([u32; 2], PathBuf)>,
}

impl Tiles {
    /// Finds the tiles of a name that contains `<UDIM>`, or that ends with `.1001` before its extension if there are further tiles.
    /// Returns `None` for the name of a single image.
    ///
    /// # Errors
    /// Fails if the folder cannot be read, or if a name with `<UDIM>` has no tile.
    pub fn find(path: &Path) -> Result<Option<Self>, MapError> {
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return Ok(None) };
        let Some((before, after)) = name.split_once(WORD).or_else(|| of_first_tile(name)) else { return Ok(None) };
        let number = |tile: &Path| {
            let number = tile.file_name()?.to_str()?.strip_prefix(before)?.strip_suffix(after)?;
            let is_number = number.len() == 4 && number.bytes().all(|digit| digit.is_ascii_digit());
            number.parse().ok().filter(|&number: &u32| is_number && number >= FIRST)
        };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let found = match matching(folder, |tile| number(tile).is_some()) {
            // A folder may allow reading its files, but not its names.
            Err(MapFault::Io { .. }) if !name.contains(WORD) => return Ok(None),
            found => found.map_err(|fault| fault.in_file(path))?,
        };
        let place = |tile: PathBuf| {
            let index = number(&tile)? - FIRST;
            Some(([index % COLUMNS, index / COLUMNS], tile))
        };
        let files: Vec<_> = found.into_iter().filter_map(place).collect();
        if files.is_empty() && name.contains(WORD) {
            let what = format!("there is no tile such as {before}{FIRST}{after}");
            return Err(MapFault::unsupported(what, "name the tiles by four digits from 1001").in_file(path));
        }
        let most = |axis: usize| files.iter().map(|(tile, _)| tile[axis] + 1).max().unwrap_or(1);
        let grid = [most(0), most(1)];
        Ok((name.contains(WORD) || files.len() > 1).then_some(Self { grid, files }))
    }

    /// Returns the first file.
    pub fn first(&self) -> &Path {
        &self.files[0].1
    }

    /// Reads the tiles as one image, whose first row is on top. Missing tiles have the mean of the others, so they are flat.
    pub(crate) fn load<T: Tile>(
        &self,
        path: &Path,
        load: impl Fn(&Path) -> Result<T, MapError>,
    ) -> Result<T, MapError> {
        let first = load(self.first())?;
        let size = first.size();
        let [columns, rows] = self.grid;
        let whole = [size[0] * columns, size[1] * rows];
        let count = self.files.len() as f64;
        // The length of the files does not bound the atlas, because most tiles may be missing.
        limits::check_size(whole[0].into(), whole[1].into(), first.texel_bytes(), usize::MAX)
            .map_err(|fault| fault.in_file(path))?;
        let mut atlas = first.blank(whole).map_err(|fault| fault.in_file(path))?;
        let mut mean = vec![0.0; 4];
        let mut present = vec![false; (columns * rows) as usize];
        for (number, ([column, row], file)) in self.files.iter().enumerate() {
            let tile = if number == 0 { None } else { Some(load(file)?) };
            let tile = tile.as_ref().unwrap_or(&first);
            if tile.size() != size || tile.kind() != first.kind() {
                let [a, b] = [&first, tile]
                    .map(|tile| format!("{} x {} texels of {}", tile.size()[0], tile.size()[1], tile.kind()));
                let what = format!("it has {b}, but {} has {a}", shown_path(self.first()));
                return Err(MapFault::unsupported(what, "give all tiles one size and format").in_file(file));
            }
            atlas.put(tile, [column * size[0], (rows - 1 - row) * size[1]]);
            mean.iter_mut().zip(tile.means()).for_each(|(sum, value)| *sum += value / count);
            present[(row * columns + column) as usize] = true;
        }
        let missing: Vec<u32> = (0..).zip(&present).filter(|(_, present)| !**present).map(|(tile, _)| tile).collect();
        if !missing.is_empty() {
            let filling = first.filled(&mean);
            missing.iter().for_each(|tile| {
                atlas.put(&filling, [tile % columns * size[0], (rows - 1 - tile / columns) * size[1]])
            });
            let number = |tile: &u32| (FIRST + tile % columns + COLUMNS * (tile / columns)).to_string();
            let named: Vec<String> = missing.iter().take(MOST_NAMED).map(number).collect();
            let more = if missing.len() > MOST_NAMED { ", …" } else { "" };
            tracing::warn!("{}: missing tiles are flat: {}{more}", shown_path(path), named.join(", "));
        }
        Ok(atlas)
    }
}

/// Splits a name such as `skin.1001.png` around the number.
fn of_first_tile(name: &str) -> Option<(&str, &str)> {
    let at = name.rfind(".1001.")?;
    let after = &name[at + 5..];
    (!after[1..].contains('.')).then_some((&name[..=at], after))
}

/// An image that can be put into an atlas.
pub(crate) trait Tile: Sized {
    fn size(&self) -> [u32; 2];
    fn texel_bytes(&self) -> u64;
    /// The channels and the type of the numbers, in words.
    fn kind(&self) -> String;
    /// The mean of each channel.
    fn means(&self) -> Vec<f64>;
    /// An image of this kind and of another size.
    fn blank(&self, size: [u32; 2]) -> Result<Self, MapFault>;
    /// An image of this kind and size, of one value per channel.
    fn filled(&self, values: &[f64]) -> Self;
    /// Copies an image of this kind to a position.
    fn put(&mut self, tile: &Self, at: [u32; 2]);
}

/// Copies rows of texels of `channels` numbers.
fn copy<T: Copy>(to: &mut [T], width: u32, from: &[T], of: u32, [x, y]: [u32; 2], channels: usize) {
    let [width, of, x, y] = [width, of, x, y].map(|n| n as usize);
    for (row, texels) in from.chunks_exact(of * channels).enumerate() {
        to[((y + row) * width + x) * channels..][..of * channels].copy_from_slice(texels);
    }
}

impl Tile for HeightMap {
    fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    fn texel_bytes(&self) -> u64 {
        4
    }

    fn kind(&self) -> String {
        "heights".to_owned()
    }

    fn means(&self) -> Vec<f64> {
        vec![f64::from(self.mean())]
    }

    fn blank(&self, [width, height]: [u32; 2]) -> Result<Self, MapFault> {
        Ok(Self { width, height, texels: limits::zeroed(width as usize * height as usize)? })
    }

    fn filled(&self, values: &[f64]) -> Self {
        Self { texels: vec![values[0] as f32; self.texels.len()], ..*self }
    }

    fn put(&mut self, tile: &Self, at: [u32; 2]) {
        copy(&mut self.texels, self.width, &tile.texels, tile.width, at, 1);
    }
}

impl Tile for Raster {
    fn size(&self) -> [u32; 2] {
        Self::size(self)
    }

    fn texel_bytes(&self) -> u64 {
        let bytes = match self.samples() {
            Samples::U8(_) => 1,
            Samples::U16(_) => 2,
            Samples::F32(_) => 4,
        };
        bytes * self.channels() as u64
    }

    fn kind(&self) -> String {
        let numbers = match self.samples() {
            Samples::U8(_) => "8 bits",
            Samples::U16(_) => "16 bits",
            Samples::F32(_) => "floats",
        };
        format!("{} channels of {numbers}", self.channels())
    }

    fn means(&self) -> Vec<f64> {
        fn of<T: Copy>(samples: &[T], channels: usize, value: impl Fn(T) -> f64) -> Vec<f64> {
            let count = (samples.len() / channels).max(1) as f64;
            let channel = |k: usize| samples.iter().skip(k).step_by(channels).map(|&s| value(s)).sum::<f64>() / count;
            (0..channels).map(channel).collect()
        }
        match self.samples() {
            Samples::U8(samples) => of(samples, self.channels(), f64::from),
            Samples::U16(samples) => of(samples, self.channels(), f64::from),
            Samples::F32(samples) => of(samples, self.channels(), f64::from),
        }
    }

    fn blank(&self, [width, height]: [u32; 2]) -> Result<Self, MapFault> {
        let count = width as usize * height as usize * self.channels();
        let samples = match self.samples() {
            Samples::U8(_) => Samples::U8(limits::zeroed(count)?),
            Samples::U16(_) => Samples::U16(limits::zeroed(count)?),
            Samples::F32(_) => Samples::F32(limits::zeroed(count)?),
        };
        Self::new(width, height, self.channels(), samples)
    }

    fn filled(&self, values: &[f64]) -> Self {
        let channels = self.channels();
        let each = (0..self.width() as usize * self.height() as usize * channels).map(|i| values[i % channels]);
        let samples = match self.samples() {
            Samples::U8(_) => Samples::U8(each.map(|v| v.round() as u8).collect()),
            Samples::U16(_) => Samples::U16(each.map(|v| v.round() as u16).collect()),
            Samples::F32(_) => Samples::F32(each.map(|v| v as f32).collect()),
        };
        self.with_samples(samples)
    }

    fn put(&mut self, tile: &Self, at: [u32; 2]) {
        let (width, of, channels) = (self.width(), tile.width(), self.channels());
        match (self.samples_mut(), tile.samples()) {
            (Samples::U8(to), Samples::U8(from)) => copy(to, width, from, of, at, channels),
            (Samples::U16(to), Samples::U16(from)) => copy(to, width, from, of, at, channels),
            (Samples::F32(to), Samples::F32(from)) => copy(to, width, from, of, at, channels),
            // Tiles of one atlas have one kind.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::save::save_png_grey16;
    use crate::{load_height_map, load_raster};

    fn put(folder: &Path, name: &str, size: [u32; 2], height: f32) {
        let [width, height_of] = size;
        let texels = (0..width * height_of).map(|i| height + i as f32 / 1000.0).collect();
        save_png_grey16(folder.join(name), &HeightMap { width, height: height_of, texels }, 0.0, 1.0).unwrap();
    }

    #[test]
    fn tiles_lie_in_one_image() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        put(folder, "a.1001.png", [4, 2], 0.1);
        put(folder, "a.1003.png", [4, 2], 0.3);
        put(folder, "a.1012.png", [4, 2], 0.5);
        // Names that are not tiles of this map.
        for other in ["a.0900.png", "a.10012.png", "a.1004.exr", "b.1002.png", "a.+100.png"] {
            put(folder, other, [1, 1], 0.0);
        }
        let tiles = Tiles::find(&folder.join("a.<UDIM>.png")).unwrap().unwrap();
        assert_eq!(tiles.grid, [3, 2]);
        assert_eq!(Tiles::find(&folder.join("a.1001.png")).unwrap().as_ref(), Some(&tiles));
        let map = load_height_map(folder.join("a.<UDIM>.png")).unwrap();
        assert_eq!((map.width, map.height), (12, 4));
        let at = |x: u32, y: u32| map.texels[(y * 12 + x) as usize];
        let is = |found: f32, wanted: f32| (found - wanted).abs() < 2e-5;
        // The first row of tiles is at the bottom. Texels count from the top left of each tile.
        assert!(is(at(0, 2), 0.1) && is(at(3, 3), 0.107) && is(at(8, 2), 0.3) && is(at(4, 0), 0.5), "{:?}", map.texels);
        // Missing tiles are flat, at the mean of the others.
        let mean = (0.1 + 0.3 + 0.5) / 3.0 + 0.0035;
        for (x, y) in [(4, 2), (7, 3), (0, 0), (11, 1)] {
            assert!(is(at(x, y), mean), "{x} {y}: {}", at(x, y));
        }
        let raster = load_raster(folder.join("a.1001.png")).unwrap();
        assert_eq!((raster.size(), raster.channels()), ([12, 4], 1));
        assert!(is(raster.value(4, 0, 0), 0.5) && is(raster.value(0, 0, 0), mean));
    }

    #[test]
    fn single_images_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in ["a.1001.png", "b.1002.png", "b.1003.png", "c.png"] {
            put(folder, name, [2, 2], 0.5);
            assert_eq!(Tiles::find(&folder.join(name)).unwrap(), None, "{name}");
            assert_eq!(load_height_map(folder.join(name)).unwrap().width, 2);
        }
        assert_eq!(Tiles::find(&folder.join("b.<UDIM>.png")).unwrap().unwrap().grid, [3, 1]);
    }

    #[test]
    fn faults_take_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let fault = |name: &str| {
            let text = load_height_map(folder.join(name)).unwrap_err().to_string();
            assert!(!text.contains('\n'), "{text}");
            text
        };
        assert!(fault("a.<UDIM>.png").contains("there is no tile such as a.1001.png"));
        put(folder, "a.1001.png", [2, 2], 0.5);
        put(folder, "a.1002.png", [4, 2], 0.5);
        let text = fault("a.<UDIM>.png");
        assert!(text.contains("a.1002.png") && text.contains("4 x 2") && text.contains("one size"), "{text}");
        // The last tile makes an atlas of 10 by 900 tiles.
        put(folder, "b.1001.png", [256, 256], 0.0);
        put(folder, "b.9999.png", [256, 256], 0.0);
        let text = fault("b.<UDIM>.png");
        assert!(text.contains("limit") && text.contains("b.<UDIM>.png"), "{text}");
        std::fs::write(folder.join("c.1001.png"), b"no picture").unwrap();
        assert!(fault("c.<UDIM>.png").contains("c.1001.png"));
        std::fs::remove_file(folder.join("a.1002.png")).unwrap();
        std::fs::write(folder.join("a.1002.png"), b"no picture").unwrap();
        assert!(fault("a.1001.png").contains("a.1002.png"));
    }
}
