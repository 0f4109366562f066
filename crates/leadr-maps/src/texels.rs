//! Texel formats of GPU textures, and their conversion to a [`Raster`]. Other crates decode the blocks of colours.

use half::f16;
use texture2ddecoder as blocks;

use super::material::{Raster, Samples};
use super::raster_read::Size;
use super::{MapFault, bc5, limits};

/// The format of the texels of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TexelFormat {
    /// Numbers for each texel. `kept` of the `stored` channels are used. With `bgr`, red and blue are swapped.
    Plain { stored: usize, kept: usize, number: Number, bgr: bool },
    /// Blocks of 4 x 4 texels with one or two channels of 8 bytes (BC4, BC5, EAC), whose values need more than 8 bits.
    Numbers { channels: usize, eac: bool, signed: bool },
    /// Blocks of colours with 8 bits per channel.
    Colors(ColorBlock),
}

/// A stored number. Signed codes from -1 to 1 become codes from 0 to 1, as normal maps store them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Unorm8,
    Snorm8,
    Unorm16,
    Snorm16,
    Half,
    Float,
}

/// A block of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorBlock {
    Bc1 { alpha: bool },
    Bc2,
    Bc3,
    Bc7,
    Etc2,
    Etc2Mask,
    Etc2Alpha,
    Astc { width: usize, height: usize },
}

/// The maximum number of texels in a block: 12 x 12 of ASTC.
const MOST_TEXELS: usize = 144;

/// The modifiers of EAC blocks (Khronos Data Format Specification 1.3, table 109).
const EAC: [[i32; 8]; 16] = [
    [-3, -6, -9, -15, 2, 5, 8, 14],
    [-3, -7, -10, -13, 2, 6, 9, 12],
    [-2, -5, -8, -13, 1, 4, 7, 12],
    [-2, -4, -6, -13, 1, 3, 5, 12],
    [-3, -6, -8, -12, 2, 5, 7, 11],
    [-3, -7, -9, -11, 2, 6, 8, 10],
    [-4, -7, -8, -11, 3, 6, 7, 10],
    [-3, -5, -8, -11, 2, 4, 7, 10],
    [-2, -6, -8, -10, 1, 5, 7, 9],
    [-2, -5, -8, -10, 1, 4, 7, 9],
    [-2, -4, -8, -10, 1, 3, 7, 9],
    [-2, -5, -7, -10, 1, 4, 6, 9],
    [-3, -4, -7, -10, 2, 3, 6, 9],
    [-1, -2, -3, -10, 0, 1, 2, 9],
    [-4, -6, -8, -9, 3, 5, 7, 8],
    [-3, -5, -7, -9, 2, 4, 6, 8],
];

impl Number {
    const fn bytes(self) -> usize {
        match self {
            Self::Unorm8 | Self::Snorm8 => 1,
            Self::Unorm16 | Self::Snorm16 | Self::Half => 2,
            Self::Float => 4,
        }
    }
}

impl ColorBlock {
    const fn has_alpha(self) -> bool {
        !matches!(self, Self::Bc1 { alpha: false } | Self::Etc2)
    }

    fn decode(self, block: &[u8], texels: &mut [u32; MOST_TEXELS]) {
        match self {
            Self::Bc1 { alpha: false } => blocks::decode_bc1_block(block, texels),
            Self::Bc1 { alpha: true } => blocks::decode_bc1a_block(block, texels),
            Self::Bc2 => blocks::decode_bc2_block(block, texels),
            Self::Bc3 => blocks::decode_bc3_block(block, texels),
            Self::Bc7 => blocks::decode_bc7_block(block, texels),
            Self::Etc2 => blocks::decode_etc2_rgb_block(block, texels),
            Self::Etc2Mask => blocks::decode_etc2_rgba1_block(block, texels),
            Self::Etc2Alpha => blocks::decode_etc2_rgba8_block(block, texels),
            Self::Astc { width, height } => blocks::decode_astc_block(block, width, height, texels),
        }
    }
}

impl TexelFormat {
    /// Returns the format with all its channels as stored.
    pub const fn plain(channels: usize, number: Number) -> Self {
        Self::Plain { stored: channels, kept: channels, number, bgr: false }
    }

    /// Returns the format of 8-bit blue, green and red, and of alpha or padding as a fourth channel.
    pub const fn bgr(stored: usize, kept: usize) -> Self {
        Self::Plain { stored, kept, number: Number::Unorm8, bgr: true }
    }

    /// Returns the number of channels of the decoded image.
    pub const fn channels(self) -> usize {
        match self {
            Self::Plain { kept, .. } => kept,
            Self::Numbers { channels, .. } => channels,
            Self::Colors(block) => {
                if block.has_alpha() {
                    4
                } else {
                    3
                }
            }
        }
    }

    /// Returns the size of a decoded image.
    pub fn size(self, width: u32, height: u32) -> Size {
        let sample_bytes = match self {
            Self::Plain { number: Number::Unorm8 | Number::Snorm8, .. } | Self::Colors(_) => 1,
            Self::Plain { number: Number::Unorm16 | Number::Snorm16, .. } | Self::Numbers { .. } => 2,
            Self::Plain { .. } => 4,
        };
        Size { width: width.into(), height: height.into(), channels: self.channels(), sample_bytes }
    }

    /// Returns the width and the height of a block in texels, and its bytes. A texel without blocks is a block of 1 x 1.
    const fn block(self) -> ([usize; 2], usize) {
        match self {
            Self::Plain { stored, number, .. } => ([1, 1], stored * number.bytes()),
            Self::Numbers { channels, .. } => ([4, 4], 8 * channels),
            Self::Colors(ColorBlock::Bc1 { .. } | ColorBlock::Etc2 | ColorBlock::Etc2Mask) => ([4, 4], 8),
            Self::Colors(ColorBlock::Astc { width, height }) => ([width, height], 16),
            Self::Colors(_) => ([4, 4], 16),
        }
    }

    /// Returns the number of bytes of an image.
    pub fn bytes(self, width: u32, height: u32) -> u64 {
        let ([w, h], bytes) = self.block();
        u64::from(width).div_ceil(w as u64) * u64::from(height).div_ceil(h as u64) * bytes as u64
    }

    /// Decodes an image, whose bytes are as many as [`bytes`](Self::bytes).
    ///
    /// # Errors
    /// Fails if memory runs out, or if a float is not finite.
    pub fn decode(self, bytes: &[u8], width: u32, height: u32) -> Result<Raster, MapFault> {
        let channels = self.channels();
        let samples = match self {
            Self::Plain { stored, kept, number, bgr } => plain(bytes, stored, kept, number, bgr),
            Self::Numbers { eac, signed, .. } => {
                Samples::U16(self.in_blocks(bytes, width, height, |block, texel| {
                    for (channel, part) in block.as_chunks().0.iter().enumerate() {
                        let values = match (eac, signed) {
                            (true, _) => decode_eac(part, signed),
                            (false, true) => bc5::decode(part).map(|v| 0.5 * v + 0.5),
                            (false, false) => bc5::decode_unsigned(part),
                        };
                        for (i, value) in values.into_iter().enumerate() {
                            texel[i * channels + channel] = (value * 65535.0 + 0.5) as u16;
                        }
                    }
                })?)
            }
            Self::Colors(kind) => Samples::U8(self.in_blocks(bytes, width, height, |block, texel| {
                let mut colors = [0; MOST_TEXELS];
                kind.decode(block, &mut colors);
                for (to, color) in texel.chunks_exact_mut(channels).zip(colors) {
                    let [b, g, r, a] = color.to_le_bytes();
                    to.copy_from_slice(&[r, g, b, a][..channels]);
                }
            })?),
        };
        Raster::new(width, height, channels, samples)
    }

    /// Decodes all blocks. `decode` writes the row-major texels of one block.
    ///
    /// The blocks are decoded on one thread, because a decoder may panic, and only this thread's panics are silent.
    fn in_blocks<T: bytemuck::Zeroable + Copy>(
        self,
        bytes: &[u8],
        width: u32,
        height: u32,
        decode: impl Fn(&[u8], &mut [T]),
    ) -> Result<Vec<T>, MapFault> {
        let ([w, h], block_bytes) = self.block();
        let (channels, width, height) = (self.channels(), width as usize, height as usize);
        let mut all = limits::zeroed::<T>(width * height * channels)?;
        let across = width.div_ceil(w);
        let mut texels = vec![T::zeroed(); w * h * channels];
        for (rows, blocks) in all.chunks_mut(width * h * channels).zip(bytes.chunks(across * block_bytes)) {
            for (i, block) in blocks.chunks_exact(block_bytes).enumerate() {
                decode(block, &mut texels);
                let (left, kept) = (i * w, w.min(width - i * w));
                for (row, of_block) in rows.chunks_exact_mut(width * channels).zip(texels.chunks_exact(w * channels)) {
                    row[left * channels..(left + kept) * channels].copy_from_slice(&of_block[..kept * channels]);
                }
            }
        }
        Ok(all)
    }
}

fn plain(bytes: &[u8], stored: usize, kept: usize, number: Number, bgr: bool) -> Samples {
    let texels = bytes.chunks_exact(stored * number.bytes());
    let channel = |c: usize| if bgr && c < 3 { 2 - c } else { c };
    let numbers = texels.flat_map(|texel| {
        (0..kept).map(move |c| &texel[channel(c) * number.bytes()..(channel(c) + 1) * number.bytes()])
    });
    let word = |bytes: &[u8]| u16::from_le_bytes([bytes[0], bytes[1]]);
    match number {
        Number::Unorm8 => Samples::U8(numbers.map(|bytes| bytes[0]).collect()),
        Number::Snorm8 => Samples::U8(
            numbers
                .map(|bytes| (f32::from(bytes[0].cast_signed().max(-127)) / 127.0 * 127.5 + 127.5).round() as u8)
                .collect(),
        ),
        Number::Unorm16 => Samples::U16(numbers.map(word).collect()),
        Number::Snorm16 => Samples::U16(
            numbers
                .map(|bytes| {
                    (f64::from(word(bytes).cast_signed().max(-32767)) / 32767.0 * 32767.5 + 32767.5).round() as u16
                })
                .collect(),
        ),
        Number::Half => Samples::F32(numbers.map(|bytes| f16::from_bits(word(bytes)).to_f32()).collect()),
        Number::Float => {
            Samples::F32(numbers.map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes"))).collect())
        }
    }
}

/// Decodes an EAC block of 11 bits into 16 row-major values from 0 to 1.
fn decode_eac(block: &[u8; 8], signed: bool) -> [f32; 16] {
    let [base, how, ..] = *block;
    let (modifiers, multiplier) = (&EAC[usize::from(how & 15)], i32::from(how >> 4));
    let bits = u64::from_be_bytes(*block);
    std::array::from_fn(|i| {
        // Indices are stored by columns, from the most significant bits.
        let (x, y) = (i % 4, i / 4);
        let index = (bits >> (45 - 3 * (4 * x + y)) & 7) as usize;
        let offset = modifiers[index] * if multiplier == 0 { 1 } else { 8 * multiplier };
        if signed {
            let value = i32::from(base.cast_signed().max(-127)) * 8 + offset;
            value.clamp(-1023, 1023) as f32 / 2046.0 + 0.5
        } else {
            (i32::from(base) * 8 + 4 + offset).clamp(0, 2047) as f32 / 2047.0
        }
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn of_hex(hex: &str) -> Vec<u8> {
        (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
    }

    /// A gradient of 8 x 8 texels that other programs encoded.
    pub fn gradient(x: u32, y: u32) -> [f32; 4] {
        let t = (x + y) as f32 / 14.0;
        [30.0 + 200.0 * t, 200.0 - 150.0 * t, 90.0 + 20.0 * t, 255.0 - 200.0 * t]
    }

    /// The gradient in BC7.
    pub fn bc7() -> Vec<u8> {
        of_hex(
            "40486e4c6cc5fc55217552a775daa7fd4056d5f982d1c639208552a885daa8fd4056d5f982d1c639208552a885daa8fd\
             40a41ca791dd8a9d208552a885daa8fd",
        )
    }

    #[test]
    fn blocks_of_other_encoders_show_their_picture() {
        let numbers = |channels, eac| TexelFormat::Numbers { channels, eac, signed: false };
        let astc = |width, height| TexelFormat::Colors(ColorBlock::Astc { width, height });
        let cases: [(TexelFormat, &str, f32); 12] = [
            (
                TexelFormat::Colors(ColorBlock::Bc1 { alpha: false }),
                "2c6e6b24ffbfafabcdac0c5bffbfafabcdac0c5bffbfafab6de3ac91ffbfafab",
                45.0,
            ),
            (
                TexelFormat::Colors(ColorBlock::Bc3),
                "ffa9d0aad5ab5f3f2c6e6b24ffbfafabc670d0aad5ab5f3fcdac0c5bffbfafabc670d0aad5ab5f3fcdac0c5bffbfafab\
                 8d37d0aad5ab5f3f6de3ac91ffbfafab",
                45.0,
            ),
            (numbers(1, false), "741eb97b77eed409ad57b97b77eed409ad57b97b77eed409e690b97b77eed409", 8.0),
            (
                numbers(2, false),
                "741eb97b77eed409c888d0aad5ab5f3fad57b97b77eed4099d5dd0aad5ab5f3fad57b97b77eed4099d5dd0aad5ab5f3f\
                 e690b97b77eed4097232d0aad5ab5f3f",
                8.0,
            ),
            (TexelFormat::Colors(ColorBlock::Bc7), "", 4.0),
            (
                TexelFormat::Colors(ColorBlock::Etc2),
                "8f46f32b9cc2b398ab9c1c4a72cc8e59ab9c1c4a72cc8e5948721ce648de491b",
                5.0,
            ),
            (
                TexelFormat::Colors(ColorBlock::Etc2Alpha),
                "d430facd61b0a8538f46f32b9cc2b3989b30facd61b0a853ab9c1c4a72cc8e599b30facd61b0a853ab9c1c4a72cc8e59\
                 6230facd61b0a85348721ce648de491b",
                7.0,
            ),
            (numbers(1, true), "493068c46532e977823068c46532e977823068c46532e977bb3068c46532e977", 7.0),
            (
                numbers(2, true),
                "493068c46532e977a832facd61b0a853823068c46532e9777d32facd61b0a853823068c46532e9777d32facd61b0a853\
                 bb3068c46532e9775232facd61b0a853",
                8.0,
            ),
            (
                astc(4, 4),
                "2382cddcf663e3431550abdfefa40f1a238287522aa961380f50abdfefa40d1a238287522aa961380f50abdfefa40d1a\
                 23823b079e8d697b0e50abdfefa40d1a",
                4.0,
            ),
            (
                astc(6, 6),
                "83823b5c93b9b4d0fedf2456defc0912338177e42129669baafcff97243149123f8077e42129669baa3c7cf8f0e1c319\
                 14a177f18db6002f52bf7f73777bfd2d",
                7.0,
            ),
            (astc(8, 5), "83823f748fa7b4d4fcc7a0de5ed6cd02bf83cfca2565c2dc6c71f899ffcc8601", 4.0),
        ];
        for (format, hex, tolerance) in cases {
            let bytes = if hex.is_empty() { bc7() } else { of_hex(hex) };
            assert_eq!(format.bytes(8, 8), bytes.len() as u64, "{format:?}");
            let raster = format.decode(&bytes, 8, 8).unwrap();
            assert_eq!(raster.channels(), format.channels());
            // Raster::value(3) is the second of two channels.
            let channels: &[usize] = [&[0][..], &[0, 3], &[0, 1, 2], &[0, 1, 2, 3]][raster.channels() - 1];
            for (x, y) in (0..64).map(|i| (i % 8, i / 8)) {
                for (expected, &channel) in channels.iter().enumerate() {
                    let (value, wanted) = (255.0 * raster.value(x, y, channel), gradient(x, y)[expected]);
                    assert!((value - wanted).abs() <= tolerance, "{format:?} {x} {y} {channel}: {value} {wanted}");
                }
            }
            // A texture whose sides are no multiples of the block.
            let part = format.decode(&bytes, 7, 6).unwrap();
            assert_eq!((part.size(), part.value(6, 5, 0)), ([7, 6], raster.value(6, 5, 0)));
        }
    }

    #[test]
    fn hostile_blocks_are_decoded_or_refused() {
        let colors = [ColorBlock::Bc1 { alpha: true }, ColorBlock::Bc2, ColorBlock::Bc3, ColorBlock::Bc7];
        let etc = [ColorBlock::Etc2, ColorBlock::Etc2Mask, ColorBlock::Etc2Alpha];
        let astc = [(4, 4), (8, 6), (12, 12)].map(|(width, height)| ColorBlock::Astc { width, height });
        let mut seed = 7u64;
        for block in colors.into_iter().chain(etc).chain(astc) {
            let format = TexelFormat::Colors(block);
            for round in 0..2000u64 {
                let bytes: Vec<u8> = (0..16)
                    .map(|i| {
                        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                        // Every fourth block begins with one of the first bytes in order.
                        if round % 4 == 0 && i == 0 { (round / 4) as u8 } else { (seed >> 56) as u8 }
                    })
                    .collect();
                let length = format.bytes(3, 2) as usize;
                let decoded = crate::guard::guarded("texture", || format.decode(&bytes[..length], 3, 2));
                assert!(
                    decoded.is_ok_and(|raster| raster.size() == [3, 2]) || matches!(block, ColorBlock::Astc { .. })
                );
            }
        }
    }

    #[test]
    fn signed_numbers_become_codes_around_the_middle() {
        let format = TexelFormat::plain(2, Number::Snorm8);
        let raster = format.decode(&[0x81, 0x7f], 1, 1).unwrap();
        assert_eq!(raster.samples(), &Samples::U8(vec![0, 255]));
        let raster = TexelFormat::plain(1, Number::Snorm16).decode(&[0, 0], 1, 1).unwrap();
        assert_eq!(raster.samples(), &Samples::U16(vec![32768]));
        let block = bc5::encode(&[-1.0; 16]);
        let signed = TexelFormat::Numbers { channels: 1, eac: false, signed: true };
        assert_eq!(signed.decode(&block, 4, 4).unwrap().value(2, 1, 0), 0.0);
        let raster = TexelFormat::bgr(4, 3).decode(&[1, 2, 3, 4], 1, 1).unwrap();
        assert_eq!(raster.samples(), &Samples::U8(vec![3, 2, 1]));
        assert!(TexelFormat::plain(1, Number::Float).decode(&f32::NAN.to_le_bytes(), 1, 1).is_err());
    }
}
