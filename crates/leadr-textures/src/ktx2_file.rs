//! KTX2 files of compressed textures (Khronos KTX file format 2.0).

use rayon::prelude::*;

use crate::blocks::{BlockFormat, Blocks};

const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
const VK_FORMAT_BC7_UNORM_BLOCK: u32 = 145;
const VK_FORMAT_BC7_SRGB_BLOCK: u32 = 146;
const ZSTANDARD: u32 = 2;
/// The level of the Zstandard compression. Higher levels take many times as long for a few percent.
const ZSTANDARD_LEVEL: i32 = 9;
const HEADER: usize = 80;
const LEVEL_INDEX: usize = 24;

/// Returns the bytes of a file with all levels, each compressed by Zstandard.
pub fn ktx2(blocks: &Blocks) -> Vec<u8> {
    let stored: Vec<Vec<u8>> = blocks
        .levels
        .par_iter()
        .map(|level| zstd::bulk::compress(level, ZSTANDARD_LEVEL).expect("memory for a level"))
        .collect();
    let descriptor = descriptor(blocks);
    let keys = keys();
    let descriptor_at = HEADER + LEVEL_INDEX * stored.len();
    let keys_at = descriptor_at + descriptor.len();
    let format = match (blocks.format, blocks.srgb) {
        (BlockFormat::Uastc, _) => 0,
        (BlockFormat::Bc7, false) => VK_FORMAT_BC7_UNORM_BLOCK,
        (BlockFormat::Bc7, true) => VK_FORMAT_BC7_SRGB_BLOCK,
    };
    let [width, height] = blocks.size;
    // The type size, no depth, no layers, one face.
    let counts = [format, 1, width, height, 0, 0, 1, stored.len() as u32, ZSTANDARD];
    let index = [descriptor_at, descriptor.len(), keys_at, keys.len()].map(|part| part as u32);
    let mut file = IDENTIFIER.to_vec();
    file.extend(counts.into_iter().chain(index).flat_map(u32::to_le_bytes));
    file.extend([0; 16]); // no global data of the supercompression
    // The smallest level comes first.
    let mut offsets = vec![0; stored.len()];
    let mut end = keys_at + keys.len();
    for (offset, level) in offsets.iter_mut().zip(&stored).rev() {
        *offset = end;
        end += level.len();
    }
    for ((offset, level), whole) in offsets.into_iter().zip(&stored).zip(&blocks.levels) {
        file.extend([offset, level.len(), whole.len()].into_iter().flat_map(|value| (value as u64).to_le_bytes()));
    }
    file.extend(descriptor);
    file.extend(keys);
    stored.iter().rev().for_each(|level| file.extend(level));
    file
}

/// Returns the data format descriptor, which has one sample of 16 bytes.
fn descriptor(blocks: &Blocks) -> Vec<u8> {
    const SIZE: u8 = 40;
    let (model, channel) = match blocks.format {
        BlockFormat::Uastc => (166, if blocks.alpha { 3 } else { 0 }),
        BlockFormat::Bc7 => (134, 0),
    };
    // Colours are sRGB with the primaries of BT.709. Data are linear and have no primaries.
    let (primaries, transfer) = if blocks.srgb { (1, 2) } else { (0, 1) };
    [
        u32::from(SIZE + 4).to_le_bytes(),
        [0; 4],                          // vendor and type
        [2, 0, SIZE, 0],                 // version and block size
        [model, primaries, transfer, 0], // straight alpha
        [3, 3, 0, 0],                    // texel block dimensions, minus one
        [16, 0, 0, 0],                   // bytes of the first plane
        [0; 4],
        [0, 0, 127, channel], // bit offset, bit length minus one
        [0; 4],               // sample position
        [0; 4],               // lowest value
        [0xff; 4],            // highest value
    ]
    .concat()
}

fn keys() -> Vec<u8> {
    let mut bytes = Vec::new();
    let writer = concat!("leadr-vk ", env!("CARGO_PKG_VERSION"));
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", writer)] {
        let pair = [key.as_bytes(), &[0], value.as_bytes(), &[0]].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use ktx2::{ColorModel, Format, Reader, SupercompressionScheme, TransferFunction};

    use super::*;

    #[test]
    fn another_reader_finds_every_level() {
        for format in [BlockFormat::Uastc, BlockFormat::Bc7] {
            let levels = vec![vec![1; 16 * 15], vec![2; 16 * 4], vec![3; 16], vec![4; 16]];
            let blocks = Blocks { format, srgb: true, alpha: true, size: [20, 12], levels };
            let file = ktx2(&blocks);
            let reader = Reader::new(&file).expect("a KTX2 file");
            let header = reader.header();
            assert_eq!([header.pixel_width, header.pixel_height, header.level_count], [20, 12, 4]);
            assert_eq!(header.supercompression_scheme, Some(SupercompressionScheme::Zstandard));
            let model = match format {
                BlockFormat::Uastc => {
                    assert_eq!(header.format, None);
                    ColorModel::UASTC
                }
                BlockFormat::Bc7 => {
                    assert_eq!(header.format, Some(Format::BC7_SRGB_BLOCK));
                    ColorModel::BC7
                }
            };
            assert_eq!((reader.color_model(), reader.transfer_function()), (Some(model), Some(TransferFunction::SRGB)));
            for (level, whole) in reader.levels().zip(&blocks.levels) {
                assert_eq!(level.uncompressed_byte_length, whole.len() as u64);
                assert_eq!(zstd::bulk::decompress(level.data, whole.len()).unwrap(), *whole);
            }
            let keys: Vec<_> = reader.key_value_data().map(|(key, _)| key.to_owned()).collect();
            assert_eq!(keys, ["KTXorientation", "KTXwriter"]);
        }
    }
}
