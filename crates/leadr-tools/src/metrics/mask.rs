//! A mask of the pixels that a measurement includes.

use std::path::Path;

use leadr_maps::{MapError, MapFault, load_raster};

/// A set of pixels of a picture, in row-major order from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// Whether each pixel is in the mask.
    pub inside: Vec<bool>,
}

impl Mask {
    /// Returns the pixels whose `coverage` (0 to 1) is at least `least`. NaN counts as uncovered. Fails if a side is 0, or
    /// if the length is not `width * height`.
    pub fn covered(width: u32, height: u32, coverage: &[f32], least: f32) -> Result<Self, MapFault> {
        if width == 0 || height == 0 {
            return Err(MapFault::Empty { width: width.into(), height: height.into() });
        }
        if u64::from(width) * u64::from(height) != coverage.len() as u64 {
            let what = format!("{} coverages were given for {width} x {height}", coverage.len());
            return Err(MapFault::SizeMismatch { what });
        }
        Ok(Self { width, height, inside: coverage.iter().map(|&c| c >= least).collect() })
    }

    /// Reads a mask from a PNG, JPEG or EXR. Pixels over 0.5 count: of alpha if some pixel is transparent, or else of the mean of the
    /// stored colour channels. Fails if the file is no picture, or if no pixel counts.
    pub fn load(file: &Path) -> Result<Self, MapError> {
        let raster = load_raster(file)?;
        let (width, height) = (raster.width(), raster.height());
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let alpha = |(x, y)| raster.value(x, y, 3);
        let grey = |(x, y)| [0, 1, 2].map(|channel| raster.value(x, y, channel)).iter().sum::<f32>() / 3.0;
        // Many programs save a grey mask with an opaque alpha channel.
        let by_alpha = pixels().any(|pixel| alpha(pixel) < 1.0);
        let counts = |pixel| if by_alpha { alpha(pixel) > 0.5 } else { grey(pixel) > 0.5 };
        let mask = Self { width, height, inside: pixels().map(counts).collect() };
        if mask.count() == 0 {
            let remedy = "make the pixels to measure white, or opaque in a mask with alpha";
            return Err(MapFault::unsupported("no pixel of the mask is over 0.5", remedy).in_file(file));
        }
        Ok(mask)
    }

    /// Returns a mask of every pixel.
    pub fn all(width: u32, height: u32) -> Self {
        Self { width, height, inside: vec![true; width as usize * height as usize] }
    }

    /// Returns the pixels whose neighbours within `radius` rows and columns are all in the mask. Pixels beyond the border of
    /// the picture count as inside.
    pub fn eroded(&self, radius: u32) -> Self {
        let (width, height) = (self.width as usize, self.height as usize);
        let radius = radius as usize;
        let mut rows = self.inside.clone();
        for (line, out) in self.inside.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
            for (x, kept) in out.iter_mut().enumerate() {
                *kept = line[x.saturating_sub(radius)..(x + radius + 1).min(width)].iter().all(|&i| i);
            }
        }
        let inside = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                (y.saturating_sub(radius)..(y + radius + 1).min(height)).all(|y| rows[y * width + x])
            })
            .collect();
        Self { width: self.width, height: self.height, inside }
    }

    /// Returns the pixels in both masks. Panics if the sizes differ.
    pub fn and(&self, other: &Self) -> Self {
        self.where_both(other, |own, others| own && others)
    }

    /// Returns the pixels of this mask that are not in `other`. Panics if the sizes differ.
    pub fn without(&self, other: &Self) -> Self {
        self.where_both(other, |own, others| own && !others)
    }

    fn where_both(&self, other: &Self, counts: fn(bool, bool) -> bool) -> Self {
        assert_eq!((self.width, self.height), (other.width, other.height), "masks of two sizes");
        let inside = self.inside.iter().zip(&other.inside).map(|(&own, &others)| counts(own, others)).collect();
        Self { width: self.width, height: self.height, inside }
    }

    /// Counts the pixels in the mask.
    pub fn count(&self) -> usize {
        self.inside.iter().filter(|&&i| i).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erosion_keeps_a_distance_from_the_outside() {
        // The mask is a block of 5 x 4 pixels in the middle of 9 x 8, with one NaN inside the block.
        let mut coverage: Vec<f32> = (0..72)
            .map(|i| {
                let (x, y) = (i % 9, i / 9);
                if (2..7).contains(&x) && (2..6).contains(&y) { 1.0 } else { 0.4 }
            })
            .collect();
        let mask = Mask::covered(9, 8, &coverage, 0.5).unwrap();
        assert_eq!((mask.count(), mask.eroded(0) == mask), (20, true));
        let inner = mask.eroded(1);
        assert_eq!(inner.count(), 3 * 2);
        assert!(inner.inside[3 * 9 + 3] && !inner.inside[2 * 9 + 3]);
        assert_eq!((mask.eroded(2).count(), mask.eroded(9).count()), (0, 0));
        assert_eq!(mask.without(&inner).count(), 14);
        assert_eq!(mask.and(&inner), inner);
        // The border of the picture does not count as a silhouette.
        assert_eq!(Mask::all(4, 4).eroded(2).count(), 16);
        coverage[3 * 9 + 3] = f32::NAN;
        assert_eq!(Mask::covered(9, 8, &coverage, 0.5).unwrap().count(), 19);
    }

    #[test]
    fn a_file_counts_by_alpha_or_grey() {
        let folder = tempfile::tempdir().unwrap();
        let inside = |name: &str, color: image::ColorType, codes: &[u8]| {
            let file = folder.path().join(name);
            image::save_buffer(&file, codes, 3, 1, color).unwrap();
            Mask::load(&file).map(|mask| mask.inside).map_err(|fault| fault.to_string())
        };
        use image::ColorType::{L8, La8, Rgb8, Rgba8};
        assert_eq!(inside("grey.png", L8, &[0, 127, 128]), Ok(vec![false, false, true]));
        assert_eq!(inside("color.png", Rgb8, &[255, 255, 0, 255, 0, 0, 0, 0, 0]), Ok(vec![true, false, false]));
        assert_eq!(inside("alpha.png", La8, &[0, 255, 255, 0, 9, 128]), Ok(vec![true, false, true]));
        assert_eq!(
            inside("opaque.png", Rgba8, &[[255; 4], [0, 0, 0, 255], [255; 4]].concat()),
            Ok(vec![true, false, true])
        );
        assert!(inside("black.png", L8, &[0; 3]).unwrap_err().contains("no pixel of the mask"));
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(Mask::covered(3, 2, &[1.0; 5], 0.5).unwrap_err().to_string().contains("3 x 2"));
        assert!(Mask::covered(0, 2, &[], 0.5).is_err());
    }
}
