//! Texels as stored in files, without any interpretation.

use std::sync::Arc;

use crate::MapFault;
use crate::moments::Wrap;
use crate::resample::resampled_raster;
use crate::srgb::linear_from_srgb;

/// The samples of a [`Raster`] in row-major order, with interleaved channels.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 8-bit codes, where 255 means 1.
    U8(Vec<u8>),
    /// 16-bit codes, where 65535 means 1.
    U16(Vec<u16>),
    /// Floats as stored in the file.
    F32(Vec<f32>),
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::U8(s) => s.len(),
            Self::U16(s) => s.len(),
            Self::F32(s) => s.len(),
        }
    }
}

/// An uninterpreted image of one to four channels. Row 0 is on top. The image has at least one texel, and all its floats are
/// finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    width: u32,
    height: u32,
    channels: usize,
    samples: Samples,
}

impl Raster {
    /// Creates an image of `width * height` texels with 1 to 4 channels.
    ///
    /// # Errors
    /// Fails if a side is 0, if there are 0 or more than 4 channels, if the number of samples does not match the size, or if
    /// a float is not finite. The error gives the position of the float.
    pub fn new(width: u32, height: u32, channels: usize, samples: Samples) -> Result<Self, MapFault> {
        if width == 0 || height == 0 {
            return Err(MapFault::Empty { width: width.into(), height: height.into() });
        }
        let expected = u64::from(width) * u64::from(height) * channels as u64;
        if !(1..=4).contains(&channels) || expected != samples.len() as u64 {
            let what = format!("{} samples were given for {width} x {height} x {channels}", samples.len());
            return Err(MapFault::SizeMismatch { what });
        }
        if let Samples::F32(values) = &samples
            && let Some(index) = values.iter().position(|v| !v.is_finite())
        {
            let (channel, remedy) = (["R", "G", "B", "A"][index % channels], "every value must be finite");
            return Err(MapFault::bad_texel(index / channels, width, channel, values[index], remedy));
        }
        Ok(Self { width, height, channels, samples })
    }

    /// Returns the width in texels.
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in texels.
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Returns the width and height in texels.
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Returns the number of channels per texel: 1 for grey, 2 for grey and alpha, 3 for RGB, 4 for RGBA.
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// Returns the samples.
    pub const fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Returns the samples, which must stay finite.
    pub(crate) const fn samples_mut(&mut self) -> &mut Samples {
        &mut self.samples
    }

    /// Returns an image of this size with other finite samples, as many as this image has.
    pub(crate) fn with_samples(&self, samples: Samples) -> Self {
        Self { samples, ..*self }
    }

    /// Returns a channel of a texel. Codes become 0..1, and floats are as stored. Grey images return grey for each colour,
    /// and images without alpha return 1 for alpha. Panics outside the image.
    pub fn value(&self, x: u32, y: u32, channel: usize) -> f32 {
        assert!(x < self.width && y < self.height && channel < 4, "({x}, {y}), channel {channel} of {self:?}");
        let color = self.channels - usize::from(self.channels.is_multiple_of(2));
        let channel = match channel {
            3 if color == self.channels => return 1.0,
            3 => color,
            c => c.min(color - 1),
        };
        let index = (y as usize * self.width as usize + x as usize) * self.channels + channel;
        match &self.samples {
            Samples::U8(s) => f32::from(s[index]) / 255.0,
            Samples::U16(s) => f32::from(s[index]) / 65535.0,
            Samples::F32(s) => s[index],
        }
    }

    /// Returns an image of the given stored channels.
    pub(super) fn selected(&self, channels: &[usize]) -> Self {
        fn select<T: Copy>(all: &[T], stored: usize, channels: &[usize]) -> Vec<T> {
            all.chunks_exact(stored).flat_map(|texel| channels.iter().map(|&channel| texel[channel])).collect()
        }
        let samples = match &self.samples {
            Samples::U8(all) => Samples::U8(select(all, self.channels, channels)),
            Samples::U16(all) => Samples::U16(select(all, self.channels, channels)),
            Samples::F32(all) => Samples::F32(select(all, self.channels, channels)),
        };
        Self { channels: channels.len(), samples, ..*self }
    }

    /// Returns the image at another size, in linear floats. `encoding` is that of the codes. Where the size is smaller, texels are means by
    /// area.
    pub fn resampled(&self, size: [u32; 2], encoding: Encoding) -> Self {
        resampled_raster(self, size, encoding, Wrap::Clamp)
    }

    /// Returns the linear colour of a texel. `encoding` applies to codes only, because floats are always linear.
    pub fn color(&self, x: u32, y: u32, encoding: Encoding) -> [f32; 3] {
        let codes = [0, 1, 2].map(|channel| self.value(x, y, channel));
        match (encoding, &self.samples) {
            (Encoding::Linear | Encoding::Slopes, _) | (_, Samples::F32(_)) => codes,
            (Encoding::Srgb, _) => codes.map(linear_from_srgb),
        }
    }
}

/// What the codes of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// Linear data, such as roughness, normals, heights or masks.
    #[default]
    Linear,
    /// sRGB colours.
    Srgb,
    /// Slopes as floats instead of normals: rise over run along `s` and `t` (down).
    Slopes,
}

/// How a texture is addressed outside 0..1 along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TextureWrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The texture repeats, and every second copy is mirrored.
    Mirror,
    /// The edge texel repeats.
    Clamp,
}

impl TextureWrap {
    /// Returns the texel that index `i` addresses on a side of `length` texels.
    pub fn texel(self, i: i64, length: u32) -> u32 {
        let length = i64::from(length);
        (match self {
            Self::Repeat => i.rem_euclid(length),
            Self::Mirror => {
                let i = i.rem_euclid(2 * length);
                i.min(2 * length - 1 - i)
            }
            Self::Clamp => i.clamp(0, length - 1),
        }) as u32
    }
}

/// An image applied to a surface.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The texels, which several textures may share.
    pub raster: Arc<Raster>,
    /// The name in messages: the file name, or the names of the file and the image in it.
    pub name: String,
    /// The encoding of the texel codes.
    pub encoding: Encoding,
    /// The index of the mesh's set of texture coordinates, counted from 0.
    pub coordinates: u32,
    /// The transform from mesh coordinates to texture space. The image covers `[0, 1]²`, and `t` points down.
    pub transform: glam::Affine2,
    /// The addressing modes along `s` and `t`.
    pub wrap: [TextureWrap; 2],
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        let Self { raster, name, encoding, coordinates, transform, wrap } = other;
        (&self.name, self.encoding, self.coordinates, self.transform, self.wrap)
            == (name, *encoding, *coordinates, *transform, *wrap)
            // Texels are compared only if the textures do not share them.
            && (Arc::ptr_eq(&self.raster, raster) || self.raster == *raster)
    }
}

impl Texture {
    /// Creates a repeating texture that uses the first coordinate set.
    pub fn new(raster: Raster, name: impl Into<String>, encoding: Encoding) -> Self {
        Self {
            raster: Arc::new(raster),
            name: name.into(),
            encoding,
            coordinates: 0,
            transform: glam::Affine2::IDENTITY,
            wrap: [TextureWrap::Repeat; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_every_kind_of_image() {
        let image = |channels, samples| Raster::new(1, 1, channels, Samples::U8(samples)).unwrap();
        let all = |raster: &Raster| [0, 1, 2, 3].map(|c| (raster.value(0, 0, c) * 255.0).round() as u8);
        assert_eq!(all(&image(1, vec![7])), [7, 7, 7, 255]);
        assert_eq!(all(&image(2, vec![7, 9])), [7, 7, 7, 9]);
        assert_eq!(all(&image(3, vec![1, 2, 3])), [1, 2, 3, 255]);
        assert_eq!(all(&image(4, vec![1, 2, 3, 4])), [1, 2, 3, 4]);
    }

    #[test]
    fn wrong_sizes_and_values_are_refused() {
        assert!(Raster::new(0, 1, 1, Samples::U8(vec![])).is_err());
        assert!(Raster::new(2, 1, 3, Samples::U8(vec![0; 5])).is_err());
        assert!(Raster::new(1, 1, 5, Samples::U8(vec![0; 5])).is_err());
        let nan = Raster::new(2, 1, 2, Samples::F32(vec![0.0, 0.0, 0.0, f32::NAN])).unwrap_err();
        assert!(nan.to_string().contains("channel G at x = 1, y = 0"), "{nan}");
    }

    #[test]
    fn codes_of_colours_are_decoded_and_numbers_are_not() {
        let image = Raster::new(1, 1, 1, Samples::U8(vec![188])).unwrap();
        assert!((image.color(0, 0, Encoding::Srgb)[0] - 0.5029).abs() < 1e-3);
        assert!((image.color(0, 0, Encoding::Linear)[0] - 188.0 / 255.0).abs() < 1e-6);
        let fine = Raster::new(1, 1, 1, Samples::U16(vec![188 * 257])).unwrap();
        assert!((fine.color(0, 0, Encoding::Srgb)[0] - image.color(0, 0, Encoding::Srgb)[0]).abs() < 1e-6);
    }

    #[test]
    fn indices_beyond_the_edge() {
        let read = |wrap: TextureWrap| [-2, -1, 0, 2, 3, 4].map(|i| wrap.texel(i, 3));
        assert_eq!(read(TextureWrap::Repeat), [1, 2, 0, 2, 0, 1]);
        assert_eq!(read(TextureWrap::Mirror), [1, 0, 0, 2, 2, 1]);
        assert_eq!(read(TextureWrap::Clamp), [0, 0, 0, 2, 2, 2]);
    }
}
