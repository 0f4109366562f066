//! DDS files of uncompressed textures, which engines read with their mip levels.

use leadr_maps::mips::{MipLevel, Mips};

const HEADER: u32 = 124;
const PIXEL_FORMAT: u32 = 32;
/// Capabilities, height, width, pitch, pixel format and number of mip levels are given.
const GIVEN: u32 = 0x1 | 0x2 | 0x4 | 0x8 | 0x1000 | 0x20000;
/// RGB with alpha.
const RGBA: u32 = 0x41;
/// A texture with several surfaces, which are mip levels.
const CAPABILITIES: u32 = 0x1000 | 0x8 | 0x40_0000;

/// Returns the bytes of a file with all levels, as blue, green, red and alpha of 8 bits each. The format cannot say whether colours are
/// sRGB codes, so engines ask.
pub fn dds(mips: &Mips) -> Vec<u8> {
    let [width, height] = mips.levels[0].size;
    let mut file = b"DDS ".to_vec();
    let mut put = |words: &[u32]| file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    put(&[HEADER, GIVEN, height, width, 4 * width, 0, mips.levels.len() as u32]);
    put(&[0; 11]);
    put(&[PIXEL_FORMAT, RGBA, 0, 32, 0x00ff_0000, 0x0000_ff00, 0x0000_00ff, 0xff00_0000]);
    put(&[CAPABILITIES, 0, 0, 0, 0]);
    for MipLevel { texels, .. } in &mips.levels {
        file.extend(texels.iter().flat_map(|&[r, g, b, a]| [b, g, r, a]));
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::decode_raster;
    use leadr_maps::material::Samples;

    #[test]
    fn readers_find_the_finest_level() {
        let level = |[width, height]: [u32; 2]| MipLevel {
            size: [width, height],
            texels: (0..width * height).map(|i| [i as u8, 2 * i as u8, 3 * i as u8, 255 - i as u8]).collect(),
        };
        let mips = Mips { levels: [[8, 4], [4, 2], [2, 1], [1, 1]].map(level).to_vec(), srgb: true };
        let file = dds(&mips);
        assert_eq!(file.len(), 128 + 4 * (32 + 8 + 2 + 1));
        let raster = decode_raster(&file).unwrap();
        assert_eq!((raster.size(), raster.channels()), ([8, 4], 4));
        let Samples::U8(texels) = raster.samples() else { panic!("8 bits") };
        assert_eq!(texels, mips.levels[0].texels.as_flattened());
    }
}
