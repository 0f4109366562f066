//! DDS reader for textures of one image. Only the largest mip level is read.

use super::material::Raster;
use super::raster_read::Size;
use super::texels::{ColorBlock, Number, TexelFormat};
use super::{MapFault, limits};

const REMEDY: &str = "convert it, for example with ImageMagick: magick FILE.dds FILE.png";
/// The bytes of the signature and the header.
const HEADER: usize = 128;
/// The bytes of the additional header of Direct3D 10.
const HEADER_10: usize = 20;

struct Opened {
    format: TexelFormat,
    width: u32,
    height: u32,
    /// The offset of the texels in the file.
    start: usize,
}

fn open(bytes: &[u8]) -> Result<Opened, MapFault> {
    let word = |at: usize| bytes.get(at..at + 4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")));
    let cut = || MapFault::damaged("it ends within its header (truncated?)");
    let at = |offset: usize| word(offset).ok_or_else(cut);
    let several = || MapFault::unsupported("it is a cube map, a volume or an array, and one image is expected", REMEDY);
    if at(4)? != 124 || at(76)? != 32 {
        return Err(MapFault::damaged("its header has a wrong length"));
    }
    let (height, width, code) = (at(12)?, at(16)?, at(84)?.to_le_bytes());
    if at(112)? & 0x0020_0200 != 0 {
        return Err(several());
    }
    let has_code = at(80)? & 4 != 0;
    let masks = [at(92)?, at(96)?, at(100)?, at(104)?];
    let (format, start) = match (has_code, &code) {
        (true, b"DX10") => {
            // The flag 4 marks cube maps.
            if at(HEADER + 4)? != 3 || at(HEADER + 8)? & 4 != 0 || at(HEADER + 12)? > 1 {
                return Err(several());
            }
            (of_dxgi(at(HEADER)?), HEADER + HEADER_10)
        }
        (true, _) => (of_code(&code), HEADER),
        (false, _) => (of_masks(at(88)?, masks), HEADER),
    };
    let Some(format) = format else {
        return Err(MapFault::unsupported("its texel format is not supported", REMEDY));
    };
    Ok(Opened { format, width, height, start })
}

fn of_code(code: &[u8; 4]) -> Option<TexelFormat> {
    let numbers = |channels, signed| Some(TexelFormat::Numbers { channels, eac: false, signed });
    match code {
        b"DXT1" => of_dxgi(71),
        b"DXT2" | b"DXT3" => of_dxgi(74),
        b"DXT4" | b"DXT5" => of_dxgi(77),
        b"ATI1" | b"BC4U" => numbers(1, false),
        b"BC4S" => numbers(1, true),
        // ATI2 stores y before x in some programs; BC5 is the documented order.
        b"ATI2" | b"BC5U" => numbers(2, false),
        b"BC5S" => numbers(2, true),
        _ => match u32::from_le_bytes(*code) {
            36 => of_dxgi(11),
            110 => of_dxgi(13),
            111 => of_dxgi(54),
            112 => of_dxgi(34),
            113 => of_dxgi(10),
            114 => of_dxgi(41),
            115 => of_dxgi(16),
            116 => of_dxgi(2),
            _ => None,
        },
    }
}

fn of_dxgi(format: u32) -> Option<TexelFormat> {
    use Number::{Float, Half, Snorm8, Snorm16, Unorm8, Unorm16};
    let numbers = |channels, signed| TexelFormat::Numbers { channels, eac: false, signed };
    Some(match format {
        2 => TexelFormat::plain(4, Float),
        6 => TexelFormat::plain(3, Float),
        10 => TexelFormat::plain(4, Half),
        11 | 12 => TexelFormat::plain(4, Unorm16),
        13 => TexelFormat::plain(4, Snorm16),
        16 => TexelFormat::plain(2, Float),
        28..=30 => TexelFormat::plain(4, Unorm8),
        31 => TexelFormat::plain(4, Snorm8),
        34 => TexelFormat::plain(2, Half),
        35 | 36 => TexelFormat::plain(2, Unorm16),
        37 => TexelFormat::plain(2, Snorm16),
        41 => TexelFormat::plain(1, Float),
        49 | 50 => TexelFormat::plain(2, Unorm8),
        51 => TexelFormat::plain(2, Snorm8),
        54 => TexelFormat::plain(1, Half),
        56 | 57 => TexelFormat::plain(1, Unorm16),
        58 => TexelFormat::plain(1, Snorm16),
        61 | 62 => TexelFormat::plain(1, Unorm8),
        63 => TexelFormat::plain(1, Snorm8),
        70..=72 => TexelFormat::Colors(ColorBlock::Bc1 { alpha: true }),
        73..=75 => TexelFormat::Colors(ColorBlock::Bc2),
        76..=78 => TexelFormat::Colors(ColorBlock::Bc3),
        79 | 80 => numbers(1, false),
        81 => numbers(1, true),
        82 | 83 => numbers(2, false),
        84 => numbers(2, true),
        87 | 91 => TexelFormat::bgr(4, 4),
        88 | 93 => TexelFormat::bgr(4, 3),
        97..=99 => TexelFormat::Colors(ColorBlock::Bc7),
        _ => return None,
    })
}

/// Returns the format of texels of `bits` bits, whose channels have the masks red, green, blue and alpha.
fn of_masks(bits: u32, masks: [u32; 4]) -> Option<TexelFormat> {
    use Number::{Unorm8, Unorm16};
    let kept = |stored: usize| if masks[3] == 0 { 3 } else { stored };
    Some(match (bits, masks) {
        (32, [0x00ff_0000, 0xff00, 0xff, _]) => TexelFormat::bgr(4, kept(4)),
        (32, [0xff, 0xff00, 0x00ff_0000, _]) => {
            TexelFormat::Plain { stored: 4, kept: kept(4), number: Unorm8, bgr: false }
        }
        (24, [0x00ff_0000, 0xff00, 0xff, _]) => TexelFormat::bgr(3, 3),
        (24, [0xff, 0xff00, 0x00ff_0000, _]) => TexelFormat::plain(3, Unorm8),
        (32, [0xffff, 0xffff_0000, 0, 0]) => TexelFormat::plain(2, Unorm16),
        (16, [0xffff, 0, 0, 0]) => TexelFormat::plain(1, Unorm16),
        (16, [0xff, 0, 0, 0xff00] | [0xff, 0xff00, 0, 0]) => TexelFormat::plain(2, Unorm8),
        (8, [0xff, 0, 0, 0]) => TexelFormat::plain(1, Unorm8),
        _ => return None,
    })
}

/// Returns the size in the header.
pub(super) fn declared_size(bytes: &[u8]) -> Result<Size, MapFault> {
    let Opened { format, width, height, .. } = open(bytes)?;
    Ok(format.size(width, height))
}

/// Decodes the largest mip level.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, MapFault> {
    let Opened { format, width, height, start } = open(bytes)?;
    let size = format.size(width, height);
    limits::check_size(size.width, size.height, size.texel_bytes(), bytes.len())?;
    let length = format.bytes(width, height) as usize;
    let texels = bytes.get(start..).and_then(|rest| rest.get(..length));
    format.decode(texels.ok_or_else(|| MapFault::damaged("its texels end early"))?, width, height)
}

#[cfg(test)]
mod tests {
    use crate::decode_raster;
    use crate::texels::tests::{bc7, gradient};

    fn dds(size: [u32; 2], pixel_format: [u32; 7], more: &[u32], texels: &[u8]) -> Vec<u8> {
        let mut words = vec![124, 0x1007, size[1], size[0]];
        words.resize(18, 0);
        words.extend([32].iter().chain(&pixel_format));
        words.extend([0x1000, 0, 0, 0, 0]);
        words.extend(more);
        [&b"DDS "[..], &words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>(), texels].concat()
    }

    #[test]
    fn textures_of_engines_are_read() {
        let code = |code: &[u8; 4]| [4, u32::from_le_bytes(*code), 0, 0, 0, 0, 0];
        let file = dds([8, 8], code(b"DX10"), &[99, 3, 0, 1, 0], &bc7());
        let raster = decode_raster(&file).unwrap();
        assert!((255.0 * raster.value(5, 2, 1) - gradient(5, 2)[1]).abs() < 4.0);
        let header = crate::ImageHeader::read(&file[..148], file.len() as u64).unwrap();
        assert_eq!((header.width, header.height, header.channels), (8, 8, 4));
        assert!(decode_raster(&file[..file.len() - 1]).unwrap_err().to_string().contains("its texels end early"));
        let plain = dds([1, 1], [0x41, 0, 32, 0x00ff_0000, 0xff00, 0xff, 0xff00_0000], &[], &[1, 2, 3, 4]);
        let raster = decode_raster(&plain).unwrap();
        assert_eq!([0, 1, 2, 3].map(|c| (raster.value(0, 0, c) * 255.0).round()), [3.0, 2.0, 1.0, 4.0]);
        // A red block of one colour.
        let raster = decode_raster(&dds([2, 2], code(b"DXT1"), &[], &[0, 0xf8, 0, 0xf8, 0, 0, 0, 0])).unwrap();
        assert_eq!([0, 1, 2].map(|c| raster.value(1, 1, c)), [1.0, 0.0, 0.0]);
        let hdr = decode_raster(&dds([4, 4], code(b"DX10"), &[95, 3, 0, 1, 0], &[0; 16])).unwrap_err().to_string();
        assert!(hdr.contains("its texel format is not supported; convert it"), "{hdr}");
        let cube = decode_raster(&dds([4, 4], code(b"DX10"), &[99, 3, 4, 1, 0], &[0; 16])).unwrap_err().to_string();
        assert!(cube.contains("cube map"), "{cube}");
    }
}
