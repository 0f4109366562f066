//! A rectangle of pixels that a measurement includes.

use std::str::FromStr;

use leadr_maps::{MapFault, RgbImage};
use serde::Serialize;

use super::Mask;

/// A rectangle of pixels, written as `X,Y,WIDTH,HEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "[u32; 4]")]
pub struct Crop {
    /// Left column, counted from 0.
    pub x: u32,
    /// Top row, counted from 0.
    pub y: u32,
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
}

impl From<Crop> for [u32; 4] {
    fn from(crop: Crop) -> Self {
        [crop.x, crop.y, crop.width, crop.height]
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
        match numbers[..] {
            [x, y, width, height] if width > 0 && height > 0 && text.matches(',').count() == 3 => {
                Ok(Self { x, y, width, height })
            }
            _ => Err("a crop is X,Y,WIDTH,HEIGHT in pixels from the top left, such as 64,32,256,128".to_owned()),
        }
    }
}

impl Crop {
    /// Returns the part of a picture. Fails if the rectangle exceeds the picture.
    pub fn picture(self, picture: &RgbImage) -> Result<RgbImage, MapFault> {
        let texels = self.texels(&picture.texels, picture.width, picture.height)?;
        Ok(RgbImage { width: self.width, height: self.height, texels })
    }

    /// Returns the part of a mask. Fails if the rectangle exceeds the mask.
    pub fn mask(self, mask: &Mask) -> Result<Mask, MapFault> {
        let inside = self.texels(&mask.inside, mask.width, mask.height)?;
        Ok(Mask { width: self.width, height: self.height, inside })
    }

    fn texels<T: Copy>(self, texels: &[T], width: u32, height: u32) -> Result<Vec<T>, MapFault> {
        let ends = |start: u32, length: u32| u64::from(start) + u64::from(length);
        if ends(self.x, self.width) > width.into() || ends(self.y, self.height) > height.into() {
            let Self { x, y, width: w, height: h } = self;
            let what = format!("it has {width} x {height} pixels, and the crop has {w} x {h} from ({x}, {y})");
            return Err(MapFault::unsupported(what, "give a rectangle inside the picture"));
        }
        let columns = self.x as usize..(self.x + self.width) as usize;
        let rows = texels.chunks_exact(width as usize).skip(self.y as usize).take(self.height as usize);
        Ok(rows.flat_map(|row| &row[columns.clone()]).copied().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crop_is_the_part_inside_the_picture() {
        let picture = RgbImage::new(4, 3, (0..12).map(|i| [i as f32; 3]).collect()).unwrap();
        let crop = |text: &str| text.parse::<Crop>().unwrap();
        let part = crop("1,1,2,2").picture(&picture).unwrap();
        assert_eq!((part.width, part.height), (2, 2));
        assert_eq!(part.texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [5.0, 6.0, 9.0, 10.0]);
        assert_eq!(crop("0, 0, 4, 3").picture(&picture).unwrap(), picture);
        for text in ["1,0,4,3", "0,1,4,3", "4294967295,0,4294967295,1"] {
            let fault = crop(text).picture(&picture).unwrap_err().to_string();
            assert!(fault.contains("4 x 3") && fault.contains("inside the picture"), "{fault}");
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,0", "-1,2,3,4", "a,2,3,4", "1,2,3,x", "1,2,3,4,"] {
            assert!(text.parse::<Crop>().is_err(), "'{text}'");
        }
    }
}
