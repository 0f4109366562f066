//! Decodes buffer views that are compressed by meshoptimizer (`EXT_meshopt_compression` and `KHR_meshopt_compression`).

use super::accessor::{Buffer, Unpacked};
use super::extensions::{MESHOPT, MESHOPT_KHR};
use super::json::{Item, Read};
use super::log::Log;
use crate::fault::{Broken, ModelFault};
use crate::limits::Budget;

/// The number of elements whose codes have one width.
const GROUP: usize = 16;
/// The maximum number of bytes of a block of elements.
const BLOCK_BYTES: usize = 8192;
/// The maximum number of elements of a block.
const BLOCK: usize = 256;

/// Decodes all compressed buffer views. Other views have `None`.
pub(super) fn views(root: &Item<'_>, buffers: &[Buffer<'_>], budget: &Budget, log: &Log) -> Read<Vec<Unpacked>> {
    let mut all = Vec::new();
    for item in root.items("bufferViews", "buffer view")? {
        let extension = match item.extension(MESHOPT)? {
            None => item.extension(MESHOPT_KHR)?,
            found => found,
        };
        all.push(match extension.map(|extension| view(&item, &extension, buffers, budget)) {
            Some(Err(fault)) if log.strict || matches!(fault, ModelFault::TooLarge { .. }) => return Err(fault),
            decoded => decoded.map(|decoded| decoded.map_err(Broken::new)),
        });
    }
    Ok(all)
}

fn view(item: &Item<'_>, extension: &Item<'_>, buffers: &[Buffer<'_>], budget: &Budget) -> Read<Vec<u8>> {
    let number = extension.required("buffer", |item, key| item.index(key, "buffer", buffers.len()))?;
    let offset = extension.required("byteOffset", |item, key| Ok(Some(item.whole(key)?.unwrap_or(0))))?;
    let [length, stride, count] = ["byteLength", "byteStride", "count"].map(|key| extension.required(key, Item::whole));
    let [length, stride, count] =
        [length?, stride?, count?].map(|number| usize::try_from(number).unwrap_or(usize::MAX));
    let bytes = buffers[number].bytes.as_ref().map_err(Broken::fault)?;
    let start = usize::try_from(offset).unwrap_or(usize::MAX);
    let data = bytes
        .get(start..start.saturating_add(length))
        .ok_or_else(|| item.fault("has compressed data beyond its buffer"))?;
    budget.take::<u8>(count.saturating_mul(stride))?;
    let mode = extension.required("mode", Item::string)?;
    let filter = extension.string("filter")?.unwrap_or("NONE");
    decode(data, mode, filter, count, stride)
        .ok_or_else(|| item.fault(format!("has damaged data of the compression {MESHOPT}")))
}

/// Decodes `count` elements of `stride` bytes. Returns `None` for damaged data.
fn decode(data: &[u8], mode: &str, filter: &str, count: usize, stride: usize) -> Option<Vec<u8>> {
    let mut bytes = match mode {
        "ATTRIBUTES" => attributes(data, count, stride)?,
        "TRIANGLES" => whole_numbers(&triangles(data, count)?, stride)?,
        "INDICES" => whole_numbers(&indices(data, count)?, stride)?,
        _ => return None,
    };
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => each::<1, 4>(&mut bytes, |v| octahedral(v, 127.0)),
        ("OCTAHEDRAL", 8) => each::<2, 4>(&mut bytes, |v| octahedral(v, 32767.0)),
        ("QUATERNION", 8) => each::<2, 4>(&mut bytes, quaternion),
        ("COLOR", 4) => each::<1, 4>(&mut bytes, |v| color(v, 8)),
        ("COLOR", 8) => each::<2, 4>(&mut bytes, |v| color(v, 16)),
        ("EXPONENTIAL", _) if stride.is_multiple_of(4) => each::<4, 1>(&mut bytes, exponential),
        _ => return None,
    }
    Some(bytes)
}

fn whole_numbers(numbers: &[u32], stride: usize) -> Option<Vec<u8>> {
    match stride {
        2 => Some(numbers.iter().flat_map(|&number| (number as u16).to_le_bytes()).collect()),
        4 => Some(numbers.iter().flat_map(|number| number.to_le_bytes()).collect()),
        _ => None,
    }
}

fn take<'a>(data: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, rest) = data.split_at_checked(count)?;
    *data = rest;
    Some(taken)
}

fn byte(data: &mut &[u8]) -> Option<u8> {
    take(data, 1).map(|bytes| bytes[0])
}

fn unzigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

fn attributes(mut data: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return None;
    }
    let version = byte(&mut data)?.checked_sub(0xa0).filter(|&version| version <= 1)?;
    // The last bytes are the element before the first, and then the kind of each channel of four bytes.
    let (channels, least) = if version == 0 { (0, 32) } else { (stride / 4, 24) };
    let tail = stride + channels;
    let body = data.len().checked_sub(tail.max(least))?;
    let (mut before, kinds) = data[data.len() - tail..].split_at(stride);
    data = &data[..body];
    let mut out = vec![0; count * stride];
    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK);
    for elements in out.chunks_mut(block * stride) {
        let controls = take(&mut data, channels)?;
        for channel in 0..stride / 4 {
            let control = controls.get(channel).copied().unwrap_or(0);
            let kind = kinds.get(channel).copied().unwrap_or(0);
            let mut planes = [[0; BLOCK]; 4];
            for (j, plane) in planes.iter_mut().enumerate() {
                let plane = &mut plane[..elements.len() / stride];
                match (version, control >> (2 * j) & 3) {
                    (0, _) => codes(&mut data, [0, 2, 4, 8], plane)?,
                    (_, 0) => codes(&mut data, [0, 1, 2, 4], plane)?,
                    (_, 1) => codes(&mut data, [1, 2, 4, 8], plane)?,
                    (_, 2) => {}
                    _ => plane.copy_from_slice(take(&mut data, plane.len())?),
                }
            }
            let first = &before[4 * channel..][..4];
            add_deltas(&planes, kind, first, elements.chunks_mut(stride).map(|e| &mut e[4 * channel..][..4]))?;
        }
        before = &elements[elements.len() - stride..];
    }
    data.is_empty().then_some(out)
}

/// Reads one byte of each element. Each group of elements has one of four widths in bits.
fn codes(data: &mut &[u8], widths: [usize; 4], plane: &mut [u8]) -> Option<()> {
    let groups = plane.len().div_ceil(GROUP);
    let header = take(data, groups.div_ceil(4))?;
    for (number, group) in plane.chunks_mut(GROUP).enumerate() {
        let bits = widths[usize::from(header[number / 4] >> (2 * (number % 4)) & 3)];
        let packed = take(data, GROUP * bits / 8)?;
        if bits == 8 {
            group.copy_from_slice(&packed[..group.len()]);
            continue;
        }
        if bits == 0 {
            continue;
        }
        let (per_byte, largest) = (8 / bits, (1 << bits) - 1);
        for i in 0..GROUP {
            // Single bits start at the lowest, and others at the highest.
            let slot = if bits == 1 { i % 8 } else { per_byte - 1 - i % per_byte };
            let code = packed[i / per_byte] >> (bits * slot) & largest;
            // The largest code means that a byte follows.
            let value = if code == largest { byte(data)? } else { code };
            if let Some(out) = group.get_mut(i) {
                *out = value;
            }
        }
    }
    Some(())
}

/// Adds the deltas of four bytes to the element before.
fn add_deltas<'a>(
    planes: &[[u8; BLOCK]; 4],
    kind: u8,
    first: &[u8],
    elements: impl Iterator<Item = &'a mut [u8]>,
) -> Option<()> {
    let mut before = <[u8; 4]>::try_from(first).ok()?;
    for (i, element) in elements.enumerate() {
        let delta = planes.each_ref().map(|plane| plane[i]);
        before = match kind & 3 {
            0 => std::array::from_fn(|j| before[j].wrapping_add(unzigzag(delta[j].into()) as u8)),
            1 => {
                let add = |j: usize| {
                    let delta = u16::from_le_bytes([delta[j], delta[j + 1]]);
                    let sum =
                        u16::from_le_bytes([before[j], before[j + 1]]).wrapping_add(unzigzag(delta.into()) as u16);
                    sum.to_le_bytes()
                };
                let ([a, b], [c, d]) = (add(0), add(2));
                [a, b, c, d]
            }
            2 => (u32::from_le_bytes(delta).rotate_right(u32::from(kind >> 4)) ^ u32::from_le_bytes(before))
                .to_le_bytes(),
            _ => return None,
        };
        element.copy_from_slice(&before);
    }
    Some(())
}

/// Reads a number in bytes of seven bits, the lowest first.
fn number(data: &mut &[u8]) -> Option<u32> {
    let mut sum = 0;
    for i in 0..5 {
        let part = byte(data)?;
        sum |= u32::from(part & 127) << (7 * i);
        if part < 128 {
            return Some(sum);
        }
    }
    None
}

/// The last sixteen values of a stream.
#[derive(Clone, Copy)]
struct Recent<T> {
    values: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new(value: T) -> Self {
        Self { values: [value; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.values[self.next % 16] = value;
        self.next += 1;
    }

    /// Returns the value that was pushed `back` values ago, from 1.
    fn back(&self, back: usize) -> T {
        self.values[self.next.wrapping_sub(back) % 16]
    }
}

/// Decodes the indices of triangles, which continue recent edges and vertices.
fn triangles(data: &[u8], count: usize) -> Option<Vec<u32>> {
    let version = data.first()?.checked_sub(0xe0).filter(|&version| version <= 1)?;
    if !count.is_multiple_of(3) {
        return None;
    }
    let mut data = &data[1..];
    let pairs_at = data.len().checked_sub(16)?;
    let pairs = &data[pairs_at..];
    data = &data[..pairs_at];
    let codes = take(&mut data, count / 3)?;
    let (mut edges, mut vertices) = (Recent::new([u32::MAX; 2]), Recent::new(u32::MAX));
    let (mut next, mut last) = (0u32, 0u32);
    let mut out = Vec::with_capacity(count);
    let explicit = |data: &mut &[u8], last: &mut u32| {
        *last = last.wrapping_add(unzigzag(number(data)?));
        Some(*last)
    };
    let fresh = |next: &mut u32| {
        *next = next.wrapping_add(1);
        next.wrapping_sub(1)
    };
    for &code in codes {
        let low = usize::from(code & 15);
        if code < 0xf0 {
            let [a, b] = edges.back(usize::from(code >> 4) + 1);
            let recent = if version == 0 { 15 } else { 13 };
            let (c, is_new) = if low == 0 {
                (fresh(&mut next), true)
            } else if low < recent {
                (vertices.back(low + 1), false)
            } else if low == 15 {
                (explicit(&mut data, &mut last)?, true)
            } else {
                last = if low == 13 { last.wrapping_sub(1) } else { last.wrapping_add(1) };
                (last, true)
            };
            if is_new {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            out.extend([a, b, c]);
            continue;
        }
        let pair = if code < 0xfe { pairs[low] } else { byte(&mut data)? };
        if code >= 0xfe && pair == 0 {
            next = 0;
        }
        let kinds = [if code == 0xff { 15 } else { 0 }, pair >> 4, pair & 15].map(usize::from);
        let is_explicit = |kind: usize| code >= 0xfe && kind == 15;
        // New vertices are numbered before explicit ones are read.
        let mut corners = [0; 3];
        for (corner, &kind) in corners.iter_mut().zip(&kinds) {
            *corner = match kind {
                0 => fresh(&mut next),
                kind if is_explicit(kind) => 0,
                kind => vertices.back(kind),
            };
        }
        for (corner, &kind) in corners.iter_mut().zip(&kinds) {
            if is_explicit(kind) {
                *corner = explicit(&mut data, &mut last)?;
            }
        }
        for (&corner, &kind) in corners.iter().zip(&kinds) {
            if kind == 0 || is_explicit(kind) {
                vertices.push(corner);
            }
        }
        let [a, b, c] = corners;
        [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| edges.push(edge));
        out.extend(corners);
    }
    data.is_empty().then_some(out)
}

/// Decodes indices as differences to one of the last two.
fn indices(data: &[u8], count: usize) -> Option<Vec<u32>> {
    data.first()?.checked_sub(0xd0).filter(|&version| version <= 1)?;
    let mut data = &data[1..data.len().checked_sub(4).filter(|&end| end >= 1)?];
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let code = number(&mut data)?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(unzigzag(code >> 1));
        out.push(*last);
    }
    data.is_empty().then_some(out)
}

/// Changes elements of `N` little-endian numbers of `B` bytes, with a sign.
fn each<const B: usize, const N: usize>(bytes: &mut [u8], change: impl Fn([i32; N]) -> [i32; N]) {
    for element in bytes.chunks_exact_mut(B * N) {
        let numbers = std::array::from_fn(|i| {
            let mut wide = [0; 4];
            wide[4 - B..].copy_from_slice(&element[B * i..][..B]);
            i32::from_le_bytes(wide) >> (8 * (4 - B))
        });
        for (i, number) in change(numbers).into_iter().enumerate() {
            element[B * i..][..B].copy_from_slice(&number.to_le_bytes()[..B]);
        }
    }
}

/// Decodes a direction from the surface of an octahedron. The third number is the code of 1.
fn octahedral([x, y, one, w]: [i32; 4], most: f32) -> [i32; 4] {
    let [mut x, mut y] = [x, y].map(|v| v as f32);
    let z = one as f32 - x.abs() - y.abs();
    let fold = z.min(0.0);
    x += if x >= 0.0 { fold } else { -fold };
    y += if y >= 0.0 { fold } else { -fold };
    let scale = most / (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|v| (v * scale).round() as i32);
    [x, y, z, w]
}

/// Decodes a rotation from its three smallest components. The fourth number has their scale, and the place of the largest.
fn quaternion([x, y, z, last]: [i32; 4]) -> [i32; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (last | 3) as f32;
    let [x, y, z] = [x, y, z].map(|v| v as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [0; 4];
    for (i, value) in [w, x, y, z].into_iter().enumerate() {
        out[((last & 3) as usize + i) % 4] = (value * 32767.0).round() as i32;
    }
    out
}

/// Decodes a float of an exponent in 8 bits and a mantissa in 24 bits.
fn exponential([code]: [i32; 1]) -> [i32; 1] {
    let (exponent, mantissa) = (code >> 24, code << 8 >> 8);
    [(mantissa as f32 * (exponent as f32).exp2()).to_bits() as i32]
}

/// Decodes a colour from luma, two differences and alpha. The highest bit of alpha gives the number of bits.
fn color([y, orange, green, alpha]: [i32; 4], bits: u32) -> [i32; 4] {
    let most = (1i64 << bits) - 1;
    let [luma, alpha] = [y, alpha].map(|v| i64::from(v) & most);
    let (orange, green) = (i64::from(orange), i64::from(green));
    let scale = (1i64 << (64 - alpha.leading_zeros())) - 1;
    let all = [luma + orange - green, luma + green, luma - orange - green, alpha << 1 & scale | alpha & 1];
    all.map(|v| (v as f32 * (most as f32 / scale.max(1) as f32) + 0.5).clamp(0.0, most as f32) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
    }

    /// The data are those of meshoptimizer's own encoder (gltfpack).
    #[test]
    fn attributes_of_both_versions_are_decoded() {
        let element = |i: u32| {
            let noise = i.wrapping_mul(2_654_435_761) >> 20;
            let slope =
                [i as u8, (3 * i) as u8, 7, 0, noise as u8, (i / 9) as u8, 255 - i as u8, (noise >> 4) as u8 & 3];
            [&slope[..], &[0, 0, (i & 1) as u8, 128]].concat()
        };
        let wanted: Vec<u8> = (0..40).flat_map(element).collect();
        let old = "a0152aaaaaaaaaaaaaaaaaaa00002a06666666666666666666666666666666666666660000000000001f0039393739373937393739373937393739393739373937393739373937393739ffff0000393739373937393715000020000800020000800000151555555555555555555500002a043436343413436343413434143413434143413400000000000015266666666666666666660000000000000000000000000000000000000000000000000007000000ff0000000080";
        let new = "a1a5579a152aaaaaaaaaaaaaaaaaaa00002a066666666666666666666666666666666666666600000000003939373937393739373937393739373939373937393739373937393739373939373937393739370000020204080202100002151555555555555555555500002a04343634341343634341343414341343414341340000000015266666666666666666660000000000000000000000000007000000ff0000000080000000";
        for text in [old, new] {
            let data = bytes(text);
            assert_eq!(decode(&data, "ATTRIBUTES", "NONE", 40, 12).unwrap(), wanted);
            for end in 0..data.len() {
                assert!(decode(&data[..end], "ATTRIBUTES", "NONE", 40, 12).is_none(), "{end}");
            }
        }
        // Two numbers of 16 bits, and the exclusive or of rotated numbers.
        let planes = [[1; BLOCK], [2; BLOCK], [3; BLOCK], [4; BLOCK]];
        for (kind, wanted) in [(1, [0xff, 0xfe, 0xfe, 0xfd]), (0x42, 0x1040_3020u32.to_le_bytes())] {
            let mut element = [0; 4];
            add_deltas(&planes, kind, &[0; 4], [&mut element[..]].into_iter()).unwrap();
            assert_eq!(element, wanted);
        }
    }

    #[test]
    fn triangles_and_indices_are_decoded() {
        let mut wanted: Vec<u32> = Vec::new();
        for corner in (0..5u32).flat_map(|y| (0..5).map(move |x| 6 * y + x)) {
            wanted.extend([corner, corner + 1, corner + 6, corner + 1, corner + 7, corner + 6]);
        }
        wanted.extend([0, 35, 12, 35, 0, 2, 3, 1, 2]);
        let triangles = bytes(
            "e1fe1e100e100e100e100efe1e190e180e170e160eff1e160e160e160e160eff1e160e160e160e160eff1e160e160e160e160eff2fff0f0c9f025f090c5f090c5f090c1f451813f10203007687566778a9866589689801690000",
        );
        let sequence = bytes(
            "d10004141218021204141218021204141218021204141218021204141218020e04141218021204141218021204141218021204141218021204141218020e04141218021204141218021204141218021204141218021204141218020e04141218021204141218021204141218021204141218021204141218020e041412180212041412180212041412180212041412180212041412180201045a5c010905070500000000",
        );
        let same = |decoded: Vec<u8>| {
            let (numbers, _) = decoded.as_chunks::<4>();
            let found: Vec<u32> = numbers.iter().map(|number| u32::from_le_bytes(*number)).collect();
            // A triangle may start with another corner.
            let turned = |corners: &[u32]| {
                let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
                [corners[least], corners[(least + 1) % 3], corners[(least + 2) % 3]]
            };
            assert_eq!(
                found.chunks(3).map(turned).collect::<Vec<_>>(),
                wanted.chunks(3).map(turned).collect::<Vec<_>>()
            );
        };
        same(decode(&triangles, "TRIANGLES", "NONE", wanted.len(), 4).unwrap());
        same(decode(&sequence, "INDICES", "NONE", wanted.len(), 4).unwrap());
        for end in 0..triangles.len() {
            assert!(decode(&triangles[..end], "TRIANGLES", "NONE", wanted.len(), 4).is_none(), "{end}");
        }
        for end in 0..sequence.len() {
            assert!(decode(&sequence[..end], "INDICES", "NONE", wanted.len(), 4).is_none(), "{end}");
        }
    }

    #[test]
    fn damaged_data_never_panic() {
        let data = bytes("a1a5559a152aaaaaaaaaaaaaaaaaaa00002a0666666666666666666666666666666666666666000000000f00");
        let mut state = 1u32;
        for round in 0..20_000 {
            let mut altered = data.clone();
            for byte in altered.iter_mut().skip(usize::from(round % 2 == 0)) {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *byte = if state >> 28 == 0 { (state >> 8) as u8 } else { *byte };
            }
            for (mode, header) in [("ATTRIBUTES", 0xa0), ("ATTRIBUTES", 0xa1), ("TRIANGLES", 0xe1), ("INDICES", 0xd1)] {
                altered[0] = header;
                for (count, stride) in [(0, 4), (3, 4), (33, 8), (300, 4)] {
                    for filter in ["NONE", "OCTAHEDRAL", "QUATERNION", "COLOR", "EXPONENTIAL"] {
                        let decoded = decode(&altered, mode, filter, count, stride);
                        assert!(decoded.is_none_or(|bytes| bytes.len() == count * stride));
                    }
                }
            }
        }
    }

    #[test]
    fn filters_agree_with_their_encoder() {
        assert_eq!(quaternion([-868, -1855, -289, 2045]), [-3271, 22926, -9825, -20997]);
        assert_eq!(quaternion([-1447, 1447, -1447, 2044]), [16399, -16378, 16378, -16378]);
        assert_eq!(octahedral([73, 127, 127, 127], 127.0), [0, 76, -102, 127]);
        assert_eq!(octahedral([42, 42, 127, -127], 127.0), [73, 73, 74, -127]);
        assert_eq!(octahedral([1170, 2047, 2047, 32767], 32767.0), [0, 19653, -26219, 32767]);
        let signed = |codes: [u8; 4]| codes.map(|code| i32::from(code as i8));
        assert_eq!(color(signed([144, 95, 241, 255]), 8), [254, 129, 64, 255]);
        assert_eq!(color(signed([71, 141, 212, 192]), 8), [0, 27, 230, 128]);
        let float = |code: u32| f32::from_bits(exponential([code as i32])[0] as u32);
        assert_eq!([0x0200_0005, 0xfeff_fffd, 0].map(float), [20.0, -0.75, 0.0]);
    }
}
