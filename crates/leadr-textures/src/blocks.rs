//! Block compression, 16 bytes for 4 × 4 texels.
//!
//! UASTC blocks are a subset of ASTC that loaders convert to the format of the device. glTF allows no other blocks of this quality.
//! BC7 blocks are read by graphics cards of computers as they are.

use std::borrow::Cow;

use basis_universal::{BasisTextureFormat, ColorSpace, Compressor, CompressorParams};
use intel_tex_2::{RgbaSurface, bc7};
use leadr_maps::material::{Encoding, Raster};
use leadr_maps::mips::{MipLevel, Mips};
use rayon::prelude::*;

/// A kind of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockFormat {
    /// UASTC LDR 4 × 4 (Basis Universal).
    Uastc,
    /// BC7.
    Bc7,
}

/// The width and height of a block in texels.
pub const BLOCK_SIDE: u32 = 4;

/// Returns an image whose sides are whole blocks, if they have at least one block. Other images lose up to three texels along each side.
/// `encoding` is that of the codes.
pub(crate) fn whole_blocks(raster: &Raster, encoding: Encoding) -> Cow<'_, Raster> {
    let size = raster.size().map(|side| if side < BLOCK_SIDE { side } else { side / BLOCK_SIDE * BLOCK_SIDE });
    if size == raster.size() { Cow::Borrowed(raster) } else { Cow::Owned(raster.resampled(size, encoding)) }
}

/// Compressed mip levels.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// The kind of blocks.
    pub format: BlockFormat,
    /// Whether the colour channels are sRGB codes.
    pub srgb: bool,
    /// Whether a texel has an alpha below 1.
    pub alpha: bool,
    /// The width and height of the finest level.
    pub size: [u32; 2],
    /// The blocks of each level, from the finest to the coarsest.
    pub levels: Vec<Vec<u8>>,
}

/// UASTC effort from 0 to 4. Level 2 is the library's default. Level 1 takes a quarter of its time and errs by 1 to 4 % more; level 0 is far
/// off for normals (docs/measurements/textures.md).
const UASTC_EFFORT: i32 = 1;

/// Compresses all levels.
///
/// # Panics
/// Panics if `mips` has no level, or if the Basis Universal encoder fails, which it does for images without texels only.
pub fn compress(mips: &Mips, format: BlockFormat) -> Blocks {
    let kind = Kind { srgb: mips.srgb, alpha: mips.has_alpha() };
    let encode: Encode = match format {
        BlockFormat::Uastc => uastc,
        BlockFormat::Bc7 => bc7,
    };
    let levels = mips.levels.iter().map(|level| blocks(level, kind, encode)).collect();
    Blocks { format, srgb: kind.srgb, alpha: kind.alpha, size: mips.levels[0].size, levels }
}

/// Compresses the texels of some rows of a level.
type Encode = fn(texels: &[[u8; 4]], size: [u32; 2], kind: Kind) -> Vec<u8>;

/// What an encoder has to know of a texture.
#[derive(Clone, Copy)]
struct Kind {
    srgb: bool,
    alpha: bool,
}

/// Returns the blocks of a level. Each thread compresses some rows of blocks. Blocks at the edge repeat its texels.
fn blocks(level: &MipLevel, kind: Kind, encode: Encode) -> Vec<u8> {
    const ROWS: u32 = 8 * BLOCK_SIDE;
    let [width, height] = level.size;
    let [wide, high] = level.size.map(|side| side.next_multiple_of(BLOCK_SIDE));
    let texel = |x: u32, y: u32| level.texels[(y.min(height - 1) * width + x.min(width - 1)) as usize];
    let band = |first: u32| {
        let last = high.min(first + ROWS);
        let texels: Vec<[u8; 4]> = (first..last).flat_map(|y| (0..wide).map(move |x| texel(x, y))).collect();
        encode(&texels, [wide, last - first], kind)
    };
    let firsts: Vec<u32> = (0..high).step_by(ROWS as usize).collect();
    firsts.into_par_iter().flat_map_iter(band).collect()
}

fn uastc(texels: &[[u8; 4]], [width, height]: [u32; 2], kind: Kind) -> Vec<u8> {
    let mut parameters = CompressorParams::new();
    parameters.set_basis_format(BasisTextureFormat::UASTC4x4);
    parameters.set_color_space(if kind.srgb { ColorSpace::Srgb } else { ColorSpace::Linear });
    // `set_uastc_quality_level` adds its bits to those of the default level, so it cannot choose a lower one.
    // SAFETY: the parameters are alive, and the value is a level without other flags.
    unsafe { basis_universal::sys::compressor_params_set_pack_uastc_flags(parameters.0, UASTC_EFFORT) };
    parameters.set_generate_mipmaps(false);
    parameters.set_print_status_to_stdout(false);
    parameters.source_image_mut(0).init(texels.as_flattened(), width, height, 4);
    // With more than one thread the library can wait for ever: it sets the flag that ends its threads without their mutex.
    let mut compressor = Compressor::new(1);
    // SAFETY: the image has the size of its texels, and all other parameters are in the ranges that the crate declares.
    let done = unsafe { compressor.init(&parameters).then(|| compressor.process()) };
    assert!(matches!(done, Some(Ok(()))), "the encoder failed: {done:?}");
    slice(compressor.basis_file()).to_vec()
}

/// Returns the blocks of a `.basis` file with one image of one level. UASTC slices are not compressed further.
fn slice(file: &[u8]) -> &[u8] {
    const SLICE_DESCRIPTION_AT: usize = 65; // the position of its offset in the header
    const OFFSET: usize = 13; // of the slice's offset in its description; the size follows
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    let at = word(SLICE_DESCRIPTION_AT) + OFFSET;
    &file[word(at)..word(at) + word(at + 4)]
}

fn bc7(texels: &[[u8; 4]], [width, height]: [u32; 2], kind: Kind) -> Vec<u8> {
    // Colours lose nothing by the faster search; normals err by a quarter more.
    let settings = match (kind.srgb, kind.alpha) {
        (true, false) => bc7::opaque_fast_settings(),
        (false, false) => bc7::opaque_basic_settings(),
        (true, true) => bc7::alpha_fast_settings(),
        (false, true) => bc7::alpha_basic_settings(),
    };
    let surface = RgbaSurface { data: texels.as_flattened(), width, height, stride: 4 * width };
    bc7::compress_blocks(&settings, &surface)
}

#[cfg(test)]
mod tests {
    use basis_universal::transcoding::{
        DecodeFlags, LowLevelUastcTranscoder, SliceParametersUastc, TranscoderBlockFormat,
    };

    use super::*;

    /// A chain of noisy gradients with partly transparent texels.
    fn mips(alpha: bool) -> Mips {
        let level = |[width, height]: [u32; 2]| {
            let texel = |i: u32| {
                let (x, y) = (i % width * 4, i / width * 6);
                let noise = i.wrapping_mul(2_654_435_761) >> 30;
                [(x + noise) as u8, (y + noise) as u8, 128, if alpha { (x / 2 + y / 2) as u8 } else { 255 }]
            };
            MipLevel { size: [width, height], texels: (0..width * height).map(texel).collect() }
        };
        Mips { levels: [[40, 24], [20, 12], [10, 6], [5, 3], [2, 1], [1, 1]].map(level).to_vec(), srgb: false }
    }

    #[test]
    fn small_textures_end_on_any_number_of_cores() {
        // With threads of its own the encoder waits for ever in two of three runs of this test.
        let level = MipLevel { size: [16; 2], texels: vec![[90, 90, 90, 255]; 256] };
        let mips = Mips { levels: vec![level], srgb: true };
        let first = compress(&mips, BlockFormat::Uastc).levels;
        for _ in 0..2000 {
            assert_eq!(compress(&mips, BlockFormat::Uastc).levels, first);
        }
    }

    /// Returns the root mean square of the differences, in codes.
    fn difference(level: &MipLevel, decoded: &[[u8; 4]], stride: u32) -> f64 {
        let [width, height] = level.size;
        let mut sum = 0.0;
        for (i, texel) in level.texels.iter().enumerate() {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let other = decoded[(y * stride + x) as usize];
            sum += texel.iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(b)).powi(2)).sum::<f64>();
        }
        (sum / f64::from(4 * width * height)).sqrt()
    }

    #[test]
    fn blocks_hold_the_texels_of_every_level() {
        for alpha in [false, true] {
            let mips = mips(alpha);
            let encoded = [BlockFormat::Uastc, BlockFormat::Bc7].map(|format| compress(&mips, format));
            let transcoder = LowLevelUastcTranscoder::new();
            for (i, level) in mips.levels.iter().enumerate() {
                let [across, down] = level.size.map(|side| side.div_ceil(BLOCK_SIDE));
                let [wide, high] = [across, down].map(|blocks| blocks * BLOCK_SIDE);
                assert!(encoded.iter().all(|blocks| blocks.levels[i].len() == 16 * (across * down) as usize));
                let slice = SliceParametersUastc {
                    num_blocks_x: across,
                    num_blocks_y: down,
                    has_alpha: alpha,
                    original_width: level.size[0],
                    original_height: level.size[1],
                };
                let bc7 = transcoder
                    .transcode_slice(&encoded[0].levels[i], slice, DecodeFlags::empty(), TranscoderBlockFormat::BC7)
                    .expect("valid blocks");
                for blocks in [&bc7, &encoded[1].levels[i]] {
                    let mut decoded = vec![0; (wide * high) as usize];
                    texture2ddecoder::decode_bc7(blocks, wide as usize, high as usize, &mut decoded).unwrap();
                    let rgba: Vec<[u8; 4]> =
                        decoded.iter().map(|bgra| bgra.to_le_bytes()).map(|[b, g, r, a]| [r, g, b, a]).collect();
                    let found = difference(level, &rgba, wide);
                    assert!(found < 3.0, "alpha {alpha}, level {i}: {found}");
                }
            }
        }
    }
}
