//! What a PNG says about the display of its codes: colour space, pixel shape, orientation and animation.

use image::ImageDecoder;

use super::raster_read::png_decoder;
use super::shown::shown;

const SRGB: &str = "sRGB";

/// What a viewer needs to show the codes of a PNG.
#[derive(Debug, PartialEq)]
pub(crate) struct PngInfo {
    /// The colour space: `sRGB`, or the words of the file.
    pub color_space: String,
    /// The width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The orientation as in EXIF, 1 to 8. 1 is upright.
    pub orientation: u8,
    /// The number of frames of an animation, or 1.
    pub frames: u32,
}

impl Default for PngInfo {
    /// Returns an upright picture of one frame in sRGB.
    fn default() -> Self {
        Self { color_space: SRGB.into(), pixel_aspect: 1.0, orientation: 1, frames: 1 }
    }
}

/// Reads the chunks around the pixels. Damaged chunks are left aside, because the decoder reports them.
pub(crate) fn read(bytes: &[u8]) -> PngInfo {
    let (mut info, mut at) = (PngInfo::default(), 8usize);
    let (mut strength, mut gamma, mut primaries) = (0, None, None);
    while let Some((&length, rest)) = bytes.get(at..).and_then(|rest| rest.split_first_chunk::<4>()) {
        let length = u32::from_be_bytes(length) as usize;
        let Some(data) = rest.get(4..).and_then(|rest| rest.get(..length)) else { break };
        let numbers: Vec<u32> = data.as_chunks::<4>().0.iter().take(8).map(|&four| u32::from_be_bytes(four)).collect();
        // A stronger chunk replaces a weaker one.
        let mut space = |own: u8, words: String| {
            if own > strength {
                (strength, info.color_space) = (own, words);
            }
        };
        match &rest[..4] {
            b"cICP" if data == [1, 13, 0, 1] => space(4, SRGB.into()),
            b"cICP" => space(4, format!("cICP {data:?}")),
            b"iCCP" => space(3, profile(bytes, data)),
            b"sRGB" => space(2, SRGB.into()),
            b"gAMA" => gamma = numbers.first().copied(),
            b"cHRM" => primaries = Some(numbers),
            b"acTL" => info.frames = numbers.first().copied().unwrap_or(1),
            b"pHYs" if data.len() == 9 && numbers[..2].iter().all(|&n| n > 0) => {
                info.pixel_aspect = (f64::from(numbers[1]) / f64::from(numbers[0])) as f32;
            }
            b"eXIf" => {
                let orientation = image::metadata::Orientation::from_exif_chunk(data);
                info.orientation = orientation.map_or(1, image::metadata::Orientation::to_exif);
            }
            _ => {}
        }
        // The length, the name and the checksum have four bytes each.
        at = at.saturating_add(12).saturating_add(length);
    }
    // The gamma 1/2.2 and these primaries stand for sRGB.
    let rec709 = [31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6000];
    let near = |own: &u32, other: u32| own.abs_diff(other) < 100;
    let gamma = gamma.filter(|gamma| !near(gamma, 45_455));
    let primaries =
        primaries.filter(|own| own.len() != 8 || !own.iter().zip(rec709).all(|(own, other)| near(own, other)));
    if strength == 0 && (gamma.is_some() || primaries.is_some()) {
        info.color_space =
            format!("gamma {gamma:?}, primaries {primaries:?}").replace("Some", "").replace("None", "of sRGB");
    }
    info
}

/// Returns the name of a colour profile.
fn profile(bytes: &[u8], data: &[u8]) -> String {
    let profile = png_decoder(bytes).ok().and_then(|mut decoder| decoder.icc_profile().ok().flatten());
    let text: Vec<u8> = profile.iter().flatten().copied().filter(|&byte| byte != 0).collect();
    let says = |words: &[u8]| text.windows(words.len()).any(|window| window == words);
    if says(b"sRGB") && !says(b"inear") {
        return SRGB.into();
    }
    let name = data.split(|&byte| byte == 0).next().unwrap_or(data);
    let checksum = super::checksum::checksum(&profile.unwrap_or_default()) as u32;
    format!("colour profile `{}` ({checksum:08x})", shown(&String::from_utf8_lossy(name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb8Image;
    use crate::save::encode_png_srgb8;

    fn with(chunks: &[(&[u8; 4], Vec<u8>)]) -> PngInfo {
        let png = encode_png_srgb8(&Rgb8Image::new(1, 1, vec![[1, 2, 3]]).unwrap()).unwrap();
        let mut bytes = png[..33].to_vec();
        for (name, data) in chunks {
            bytes.extend((data.len() as u32).to_be_bytes());
            bytes.extend(*name);
            bytes.extend(data);
            bytes.extend([0; 4]);
        }
        bytes.extend(&png[33..]);
        read(&bytes)
    }

    fn numbers(values: &[u32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_be_bytes()).collect()
    }

    #[test]
    fn chunks_around_the_pixels_are_read() {
        let plain = with(&[]);
        assert_eq!(
            (plain.color_space.as_str(), plain.pixel_aspect, plain.orientation, plain.frames),
            (SRGB, 1.0, 1, 1)
        );
        let rec709 = numbers(&[31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6000]);
        let adobe = numbers(&[31_270, 32_900, 64_000, 33_000, 21_000, 71_000, 15_000, 6000]);
        for (chunks, expected) in [
            (vec![(b"gAMA", numbers(&[45_455])), (b"cHRM", rec709)], "sRGB"),
            (vec![(b"gAMA", numbers(&[100_000]))], "gamma (100000), primaries of sRGB"),
            (vec![(b"gAMA", numbers(&[100_000])), (b"sRGB", vec![0])], "sRGB"),
            (vec![(b"cICP", vec![1, 13, 0, 1]), (b"gAMA", numbers(&[1]))], "sRGB"),
            (vec![(b"cICP", vec![9, 16, 0, 1]), (b"sRGB", vec![0])], "cICP [9, 16, 0, 1]"),
        ] {
            assert_eq!(with(&chunks).color_space, expected);
        }
        assert!(with(&[(b"cHRM", adobe)]).color_space.starts_with("gamma of sRGB, primaries ([31270, "));
        assert!(with(&[(b"iCCP", b"Display P3\0\0damaged".to_vec())]).color_space.contains("`Display P3`"));
        assert_eq!(with(&[(b"acTL", numbers(&[3, 0]))]).frames, 3);
        assert_eq!(with(&[(b"pHYs", [numbers(&[2000, 1000]), vec![0]].concat())]).pixel_aspect, 0.5);
        let exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
        assert_eq!(with(&[(b"eXIf", exif)]).orientation, 6);
    }
}
