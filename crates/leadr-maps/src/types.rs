//! Image types, and checks of the texel values.

use super::limits::{MAX_HEIGHT, MAX_RADIANCE};
use super::srgb::linear_of_srgb8;
use super::{MapFault, Wrap};

/// A row-major image with row 0 on top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image<T> {
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// The `width * height` texels in row-major order.
    pub texels: Vec<T>,
}

/// A map of heights over texture space. PNG heights are from 0 to 1. EXR heights are as stored and may be negative. All
/// heights are finite, and there is at least one texel.
pub type HeightMap = Image<f32>;

/// An image of linear Rec.709 colours or radiance.
pub type RgbImage = Image<[f32; 3]>;

/// An image of 8-bit sRGB codes.
pub type Rgb8Image = Image<[u8; 3]>;

impl<T> Image<T> {
    /// Creates an image. Refuses empty images, and texel counts that are not `width * height`.
    fn filled(width: u32, height: u32, texels: Vec<T>) -> Result<Self, MapFault> {
        if width == 0 || height == 0 {
            return Err(MapFault::Empty { width: width.into(), height: height.into() });
        }
        if u64::from(width) * u64::from(height) != texels.len() as u64 {
            let what = format!("{} texels were given for {width} x {height}", texels.len());
            return Err(MapFault::SizeMismatch { what });
        }
        Ok(Self { width, height, texels })
    }
}

impl<T: Copy> Image<T> {
    /// Returns the texel at column `x` and row `y`. Panics outside the image.
    pub fn at(&self, x: u32, y: u32) -> T {
        assert!(x < self.width, "column {x} of an image {} wide", self.width);
        self.texels[(y * self.width + x) as usize]
    }

    pub(crate) fn beyond(&self, x: i64, y: i64, wrap: Wrap) -> T {
        self.texels[wrap.texel(y, self.height) * self.width as usize + wrap.texel(x, self.width)]
    }
}

impl HeightMap {
    /// Returns the mean height.
    pub fn mean(&self) -> f32 {
        (self.texels.iter().map(|&h| f64::from(h)).sum::<f64>() / self.texels.len() as f64) as f32
    }

    /// Creates a height map. Fails if a side is 0, if the length is not `width * height`, or if a height is not finite or
    /// exceeds [`MAX_HEIGHT`]. The error gives the position of the height.
    pub fn new(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, MapFault> {
        let map = Self::filled(width, height, texels)?;
        match map.texels.iter().position(|h| !(-MAX_HEIGHT..=MAX_HEIGHT).contains(h)) {
            Some(at) => {
                let remedy = "heights must be finite and within 1e12";
                Err(MapFault::bad_texel(at, width, "height", map.texels[at], remedy))
            }
            None => Ok(map),
        }
    }

    /// Returns the central differences at a texel in units of height per texel.
    pub(crate) fn central_differences(&self, x: u32, y: u32, wrap: Wrap) -> [f64; 2] {
        let at = |dx, dy| f64::from(self.beyond(i64::from(x) + dx, i64::from(y) + dy, wrap));
        [0.5 * (at(1, 0) - at(-1, 0)), 0.5 * (at(0, 1) - at(0, -1))]
    }
}

impl RgbImage {
    /// Creates an image of linear colours. Fails if a side is 0 or the length is not `width * height`. Values are not
    /// checked, because a render may contain NaN. [`RgbImage::check_radiance`] checks them.
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Result<Self, MapFault> {
        Self::filled(width, height, texels)
    }

    /// Checks that all values are finite. The error gives the position of the first other value.
    pub fn check_finite(&self) -> Result<(), MapFault> {
        self.check(|v| v.is_finite(), "every value must be finite")
    }

    /// Checks that all values are finite, not negative, and at most [`MAX_RADIANCE`]. The error gives the position of the
    /// first other value.
    pub fn check_radiance(&self) -> Result<(), MapFault> {
        let remedy = "radiance must be finite, not negative and at most 1e18";
        self.check(|v| (0.0..=MAX_RADIANCE).contains(&v), remedy)
    }

    fn check(&self, good: impl Fn(f32) -> bool, remedy: &'static str) -> Result<(), MapFault> {
        let values = self.texels.as_flattened();
        match values.iter().position(|&v| !good(v)) {
            Some(at) => Err(MapFault::bad_texel(at / 3, self.width, ["R", "G", "B"][at % 3], values[at], remedy)),
            None => Ok(()),
        }
    }

    /// Returns the mean colour, summed in 64 bits.
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
    /// Creates an image of sRGB codes. Fails if a side is 0 or the length is not `width * height`.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 3]>) -> Result<Self, MapFault> {
        Self::filled(width, height, texels)
    }

    /// Converts the colours to linear values from 0 to 1.
    pub fn to_linear(&self) -> RgbImage {
        let table = linear_of_srgb8();
        let texels = self.texels.iter().map(|t| t.map(|code| table[code as usize])).collect();
        RgbImage { width: self.width, height: self.height, texels }
    }
}
