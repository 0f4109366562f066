//! Codec for single channels of BC5_SNORM, which consists of two BC4 channels (Khronos Data Format Specification 1.3,
//! section 19.5). A block of 4 x 4 values in -1..1 stores two signed byte endpoints and one 3-bit index per value.
//!
//! The encoders of existing crates take bytes. This encoder takes floats, because one layer encodes the residual of another
//! layer.

/// The number of texels along each side of a block.
pub const SIDE: usize = 4;
/// The number of bytes per channel of a block.
pub const BYTES: usize = 8;

/// Encodes 16 row-major values. The endpoints are the extremes, rounded up or down to minimise the error. The error is at
/// most 1/14 of the block's range plus one step of the byte endpoints.
pub fn encode(values: &[f32; 16]) -> [u8; BYTES] {
    let scaled = values.map(|v| (v.clamp(-1.0, 1.0)) * 127.0);
    let (low, high) = scaled.iter().fold((127.0f32, -127.0f32), |(low, high), &v| (low.min(v), high.max(v)));
    let mut best = ([low.round(); 2], f32::INFINITY);
    for first in [high.floor(), high.ceil()] {
        for second in [low.floor(), low.ceil()] {
            if first > second {
                let error =
                    scaled.iter().map(|&v| (v - between([first, second], step(v, [first, second]))).powi(2)).sum();
                if error < best.1 {
                    best = ([first, second], error);
                }
            }
        }
    }
    let ends = best.0;
    let mut bits = 0u64;
    if ends[0] > ends[1] {
        for (i, &v) in scaled.iter().enumerate() {
            // Indices 0 and 1 are the endpoints. Indices 2 to 7 are interpolated values.
            let index = match step(v, ends) {
                0 => 0,
                7 => 1,
                step => step + 1,
            };
            bits |= u64::from(index) << (3 * i);
        }
    }
    let [a, b] = ends.map(|end| (end as i8).cast_unsigned());
    let [c0, c1, c2, c3, c4, c5, ..] = bits.to_le_bytes();
    [a, b, c0, c1, c2, c3, c4, c5]
}

/// Returns the position of a value between the endpoints, in sevenths.
fn step(value: f32, [first, second]: [f32; 2]) -> u8 {
    (7.0 * (first - value) / (first - second)).round().clamp(0.0, 7.0) as u8
}

fn between([first, second]: [f32; 2], step: u8) -> f32 {
    (first * f32::from(7 - step) + second * f32::from(step)) / 7.0
}

/// Decodes a signed block into 16 row-major values from -1 to 1.
pub fn decode(block: &[u8; BYTES]) -> [f32; 16] {
    // The format defines that -128 means -127.
    let ends = [block[0], block[1]].map(|end| f32::from(end.cast_signed().max(-127)));
    decode_between(block, ends, [-127.0, 127.0])
}

/// Decodes an unsigned block (BC4_UNORM) into 16 row-major values from 0 to 1.
pub fn decode_unsigned(block: &[u8; BYTES]) -> [f32; 16] {
    decode_between(block, [block[0], block[1]].map(f32::from), [0.0, 255.0])
}

/// Decodes a block with the given endpoints. `limits` are the smallest and the largest value of the format.
fn decode_between(block: &[u8; BYTES], ends: [f32; 2], limits: [f32; 2]) -> [f32; 16] {
    let [.., c0, c1, c2, c3, c4, c5] = *block;
    let bits = u64::from_le_bytes([c0, c1, c2, c3, c4, c5, 0, 0]);
    let eight = ends[0] > ends[1];
    std::array::from_fn(|i| {
        let index = (bits >> (3 * i) & 7) as u8;
        let value = match index {
            0 => ends[0],
            1 => ends[1],
            _ if eight => between(ends, index - 1),
            6 => limits[0],
            7 => limits[1],
            _ => (ends[0] * f32::from(6 - index) + ends[1] * f32::from(index - 1)) / 5.0,
        };
        value / limits[1]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_come_back_within_a_fourteenth_of_their_range() {
        let mut state = 1u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for _ in 0..2000 {
            let (middle, reach) = (0.5 * random(), 0.5 * random());
            let values: [f32; 16] = std::array::from_fn(|_| middle + reach * random());
            let decoded = decode(&encode(&values));
            let range = values.iter().fold(-1.0f32, |a, b| a.max(*b)) - values.iter().fold(1.0f32, |a, b| a.min(*b));
            for (a, b) in values.iter().zip(decoded) {
                assert!((a - b).abs() <= range / 14.0 + 1.01 / 127.0, "{values:?} {decoded:?}");
            }
        }
        // The constant 0.25 lies between two byte values.
        assert!(decode(&encode(&[0.25; 16])).iter().all(|v| (v - 0.25).abs() <= 0.5 / 7.0 / 127.0));
        assert_eq!(decode(&encode(&[7.0; 16])), [1.0; 16]);
    }

    #[test]
    fn foreign_block_compression_is_read() {
        // Endpoints in reversed order select four interpolated values and the two extremes.
        let bits = 2u64 | 6 << 3 | 7 << 6 | 1 << 9;
        let mut block = [0u8; 8];
        block[0] = (-50i8).cast_unsigned();
        block[1] = 50;
        block[2..].copy_from_slice(&bits.to_le_bytes()[..6]);
        let values = decode(&block);
        assert_eq!(values[..5], [-30.0 / 127.0, -1.0, 1.0, 50.0 / 127.0, -50.0 / 127.0]);
        block = [0x80, 0x80, 0, 0, 0, 0, 0, 0];
        assert_eq!(decode(&block), [-1.0; 16]);
    }
}
