//! The three kinds of image, and the checks on their texels.

use super::MapFault;
use super::limits::{MAX_HEIGHT, MAX_RADIANCE};
use super::srgb::linear_of_srgb8;

/// Heights over texture space, row 0 on top. From a PNG the texels lie in 0 to 1; from an EXR they are as stored and
/// may be negative. Always finite and at least 1 x 1.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` heights, row-major.
    pub texels: Vec<f32>,
}

/// Linear Rec.709 colour or radiance, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` colours, row-major.
    pub texels: Vec<[f32; 3]>,
}

/// Colour as 8-bit sRGB codes, row 0 on top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8Image {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` codes, row-major.
    pub texels: Vec<[u8; 3]>,
}

/// Refuses buffers that do not fill `width` x `height`, and empty ones.
fn check_len(width: u32, height: u32, len: usize) -> Result<(), MapFault> {
    if width == 0 || height == 0 {
        return Err(MapFault::Empty { width: width.into(), height: height.into() });
    }
    if u64::from(width) * u64::from(height) != len as u64 {
        return Err(MapFault::SizeMismatch { what: format!("{len} texels were given for {width} x {height}") });
    }
    Ok(())
}

/// Column and row of a row-major index.
fn place(index: usize, width: u32) -> (u32, u32) {
    ((index % width as usize) as u32, (index / width as usize) as u32)
}

impl HeightMap {
    /// The mean height.
    pub fn mean(&self) -> f32 {
        (self.texels.iter().map(|&h| f64::from(h)).sum::<f64>() / self.texels.len() as f64) as f32
    }

    /// A height map of `width` x `height`. Fails when a side is 0, the length is not their product, or a height is
    /// not finite or beyond [`MAX_HEIGHT`] (its place is named).
    pub fn new(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, MapFault> {
        check_len(width, height, texels.len())?;
        if let Some(index) = texels.iter().position(|h| !(-MAX_HEIGHT..=MAX_HEIGHT).contains(h)) {
            let (x, y) = place(index, width);
            let remedy = "heights must be finite and within 1e12";
            return Err(MapFault::BadTexel { channel: "height", x, y, value: texels[index], remedy });
        }
        Ok(Self { width, height, texels })
    }

    /// The height at column `x`, row `y`; panics outside the map.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        assert!(x < self.width, "column {x} of a map {} wide", self.width);
        self.texels[(y * self.width + x) as usize]
    }
}

impl RgbImage {
    /// An image of any linear colours. Fails when a side is 0 or the length is not `width * height`; texels are not
    /// checked (a render may hold NaN; see [`RgbImage::check_radiance`]).
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Result<Self, MapFault> {
        check_len(width, height, texels.len())?;
        Ok(Self { width, height, texels })
    }

    /// The colour at column `x`, row `y`; panics outside the image.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(x < self.width, "column {x} of an image {} wide", self.width);
        self.texels[(y * self.width + x) as usize]
    }

    /// Finds the first texel that is not finite and names its place.
    pub fn check_finite(&self) -> Result<(), MapFault> {
        self.check(|v| v.is_finite(), "every value must be finite")
    }

    /// Finds the first texel that is not finite, is negative, or exceeds [`MAX_RADIANCE`], and names its place.
    pub fn check_radiance(&self) -> Result<(), MapFault> {
        let remedy = "radiance must be finite, not negative and at most 1e18";
        self.check(|v| (0.0..=MAX_RADIANCE).contains(&v), remedy)
    }

    fn check(&self, good: impl Fn(f32) -> bool, remedy: &'static str) -> Result<(), MapFault> {
        for (index, texel) in self.texels.iter().enumerate() {
            if let Some(c) = texel.iter().position(|&v| !good(v)) {
                let (x, y) = place(index, self.width);
                return Err(MapFault::BadTexel { channel: ["R", "G", "B"][c], x, y, value: texel[c], remedy });
            }
        }
        Ok(())
    }

    /// Mean colour, summed in 64 bits.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for texel in &self.texels {
            for c in 0..3 {
                sum[c] += f64::from(texel[c]);
            }
        }
        sum.map(|s| s / self.texels.len() as f64)
    }
}

impl Rgb8Image {
    /// An image of sRGB codes. Fails when a side is 0 or the length is not `width * height`.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 3]>) -> Result<Self, MapFault> {
        check_len(width, height, texels.len())?;
        Ok(Self { width, height, texels })
    }

    /// The same colours, linear, 0 to 1.
    pub fn to_linear(&self) -> RgbImage {
        let table = linear_of_srgb8();
        let texels = self.texels.iter().map(|t| t.map(|code| table[code as usize])).collect();
        RgbImage { width: self.width, height: self.height, texels }
    }
}
