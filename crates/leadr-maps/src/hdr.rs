//! Strict reader for Radiance `.hdr` files (RGBE and XYZE). Scanlines may be flat, old run-length or new run-length, in all
//! eight axis orders. Memory use is proportional to the bytes in the file, not to the size in the header.
//!
//! A texel has the value mantissa * 2^(e - 136), as in most readers. Radiance itself adds half a step. Values are divided by
//! `EXPOSURE=`, as the format specifies. `PRIMARIES=`, `GAMMA=` and `COLORCORR=` are ignored, because Photoshop writes
//! meaningless values. XYZE is converted to Rec.709 with a D65 white and clamped to 0 outside the gamut.

use super::gamut::Conversion;
use super::shown::shown;
use super::{MapFault, RgbImage, limits};

/// The maximum length of a header line in bytes. Real header lines are under 200 bytes.
const MAX_LINE: usize = 4096;
const MAX_LINES: usize = 1024;
/// Bytes of a decoded texel.
const TEXEL_BYTES: u64 = 12;

/// Whether the bytes start with the magic word of a Radiance picture. Programs write words of their own after `#?`.
pub(crate) fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Returns the width, the height and the bytes per texel in the header.
pub(crate) fn declared_size(bytes: &[u8]) -> Result<(u64, u64, u64), MapFault> {
    let (header, _) = read_header(bytes)?;
    Ok((header.width(), header.height(), TEXEL_BYTES))
}

/// Decodes a picture, and adds remarks on header lines that are ignored.
pub(crate) fn decode(bytes: &[u8], remarks: &mut Vec<String>) -> Result<RgbImage, MapFault> {
    let (header, body) = read_header(bytes)?;
    remarks.extend(header.remark.clone());
    limits::check_size(header.width(), header.height(), TEXEL_BYTES, bytes.len())?;
    let texels = header.width() as usize * header.height() as usize;
    let flat = body.get(..4 * texels).filter(|flat| flat.len() == body.len());
    let decoded = match (header.read_runs(body), flat) {
        (Ok((texels, [])), _) | (Ok((texels, _)), None) => texels,
        // Texels of a flat picture can look like run lengths. Its length shows what it is.
        (_, Some(flat)) => flat.as_chunks().0.iter().map(|texel| header.color(*texel)).collect(),
        (Err(fault), None) => return Err(fault),
    };
    let texels = header.upright(decoded);
    RgbImage::new(header.width() as u32, header.height() as u32, texels)
}

#[derive(Clone, Copy)]
struct Axis {
    is_y: bool,
    /// Whether the axis has the sign `+` in the file. `+X` runs to the right, and `-Y` runs down.
    increasing: bool,
    len: u64,
}

struct Header {
    /// The conversion from CIE XYZ, if the texels are in XYZ.
    conversion: Option<Conversion>,
    /// The value of a mantissa of 1, for each exponent.
    scales: Vec<f32>,
    /// The axes in file order. The slow axis comes first.
    axes: [Axis; 2],
    remark: Option<String>,
}

impl Header {
    fn color(&self, [r, g, b, e]: [u8; 4]) -> [f32; 3] {
        let value = [r, g, b].map(|m| f32::from(m) * self.scales[e as usize]);
        self.conversion.map_or(value, |conversion| conversion.apply(value))
    }

    /// Reads all scanlines. Returns the texels in file order, and the rest of the file.
    fn read_runs<'a>(&self, mut body: &'a [u8]) -> Result<(Vec<[f32; 3]>, &'a [u8]), MapFault> {
        let [major, minor] = self.axes.map(|axis| axis.len as usize);
        let mut texels: Vec<[f32; 3]> = Vec::new();
        let mut line = Vec::with_capacity(minor);
        for row in 0..major {
            read_scanline(&mut body, minor, &mut line)
                .map_err(|what| MapFault::damaged(format!("{what} in scanline {row} of {major}")))?;
            texels.try_reserve(minor).map_err(|_| MapFault::too_large("no memory for its texels"))?;
            texels.extend(line.iter().map(|&texel| self.color(texel)));
        }
        Ok((texels, body))
    }

    fn width(&self) -> u64 {
        if self.axes[0].is_y { self.axes[1].len } else { self.axes[0].len }
    }

    fn height(&self) -> u64 {
        if self.axes[0].is_y { self.axes[0].len } else { self.axes[1].len }
    }

    /// Reorders texels from file order to row-major order from the top left.
    fn upright(&self, texels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        let [slow, fast] = self.axes;
        if slow.is_y && !slow.increasing && fast.increasing {
            return texels;
        }
        let (width, length) = (self.width() as usize, fast.len as usize);
        // In the format, X increases to the right and Y decreases downwards.
        let along = |axis: Axis, k: usize| {
            let k = if axis.increasing == axis.is_y { axis.len as usize - 1 - k } else { k };
            if axis.is_y { k * width } else { k }
        };
        let mut upright = vec![[0.0; 3]; texels.len()];
        for (index, texel) in texels.into_iter().enumerate() {
            upright[along(slow, index / length) + along(fast, index % length)] = texel;
        }
        upright
    }
}

/// Takes one line from the front of `rest`, without its line end (`\n` or `\r\n`).
fn take_line<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], MapFault> {
    let window = &rest[..rest.len().min(MAX_LINE)];
    let Some(end) = window.iter().position(|&b| b == b'\n') else {
        return Err(MapFault::damaged(if rest.len() > MAX_LINE {
            format!("a header line is longer than {MAX_LINE} bytes")
        } else {
            "the header ends before the resolution line".into()
        }));
    };
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    Ok(line.strip_suffix(b"\r").unwrap_or(line))
}

fn read_header(bytes: &[u8]) -> Result<(Header, &[u8]), MapFault> {
    let mut rest = bytes;
    take_line(&mut rest)?;
    let (mut xyz, mut exposure, mut remark) = (false, 1.0f64, None);
    for count in 0.. {
        if count == MAX_LINES {
            return Err(MapFault::damaged(format!("its header has more than {MAX_LINES} lines")));
        }
        let line = take_line(&mut rest)?;
        if line.is_empty() {
            break;
        }
        let line = String::from_utf8_lossy(line);
        let (name, value) = line.split_once('=').map_or(("", ""), |(name, value)| (name.trim(), value.trim()));
        if name == "FORMAT" {
            xyz = match value {
                "32-bit_rle_rgbe" => false,
                "32-bit_rle_xyze" => true,
                other => {
                    let what = format!("its FORMAT is `{}`", shown(other));
                    return Err(MapFault::unsupported(what, "save it as 32-bit_rle_rgbe"));
                }
            };
        } else if name == "EXPOSURE" {
            match value.parse::<f64>() {
                // The values of several EXPOSURE lines are multiplied.
                Ok(factor) if (1e-20..=1e20).contains(&(exposure * factor)) => exposure *= factor,
                _ => remark = Some(format!("its EXPOSURE `{}` is not a positive number, and is ignored", shown(value))),
            }
        }
    }
    let line = String::from_utf8_lossy(take_line(&mut rest)?).into_owned();
    let axes = parse_resolution(&line).ok_or_else(|| {
        let line = shown(&line);
        MapFault::damaged(format!("its resolution line is `{line}`; it must look like `-Y 512 +X 1024`"))
    })?;
    let scale = |e: i32| if e == 0 { 0.0 } else { (f64::powi(2.0, e - 136) / exposure) as f32 };
    let conversion = xyz.then(Conversion::from_xyz);
    Ok((Header { conversion, scales: (0..256).map(scale).collect(), axes, remark }, rest))
}

fn parse_resolution(line: &str) -> Option<[Axis; 2]> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let axis = |name: &str, len: &str| {
        let increasing = match name.as_bytes().first()? {
            b'+' => true,
            b'-' => false,
            _ => return None,
        };
        let is_y = match &name[1..] {
            "Y" => true,
            "X" => false,
            _ => return None,
        };
        // A size may contain only digits, without a sign or exponent. Numbers beyond 64 bits are refused too.
        let len = len.bytes().all(|b| b.is_ascii_digit()).then(|| len.parse().ok())??;
        Some(Axis { is_y, increasing, len })
    };
    let [a, a_len, b, b_len] = words[..] else { return None };
    let axes = [axis(a, a_len)?, axis(b, b_len)?];
    (axes[0].is_y != axes[1].is_y).then_some(axes)
}

fn take<'a>(body: &mut &'a [u8], n: usize) -> Result<&'a [u8], &'static str> {
    let (head, tail) = body.split_at_checked(n).ok_or("the file ends")?;
    *body = tail;
    Ok(head)
}

fn read_scanline(body: &mut &[u8], len: usize, line: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    line.clear();
    match **body {
        [2, 2, high, low, ..] if high < 128 && (8..32768).contains(&len) => {
            if usize::from(high) << 8 | usize::from(low) != len {
                return Err("the run-length width differs from the resolution line");
            }
            *body = &body[4..];
            line.resize(len, [0; 4]);
            (0..4).try_for_each(|channel| read_channel(body, line, channel))
        }
        _ => read_old_scanline(body, len, line),
    }
}

fn read_channel(body: &mut &[u8], line: &mut [[u8; 4]], channel: usize) -> Result<(), &'static str> {
    let mut x = 0;
    while x < line.len() {
        let code = take(body, 1)?[0] as usize;
        let count = if code > 128 { code - 128 } else { code };
        if count == 0 {
            return Err("a run has length zero");
        }
        let target = line.get_mut(x..x + count).ok_or("a run goes past the end")?;
        if code > 128 {
            let value = take(body, 1)?[0];
            target.iter_mut().for_each(|t| t[channel] = value);
        } else {
            for (t, &value) in target.iter_mut().zip(take(body, count)?) {
                t[channel] = value;
            }
        }
        x += count;
    }
    Ok(())
}

/// Reads a flat or old run-length scanline. The texel (1, 1, 1, n) repeats the previous texel n times. Consecutive repeat
/// counts are the digits of a number in base 256.
fn read_old_scanline(body: &mut &[u8], len: usize, line: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    let mut shift = 0u32;
    while line.len() < len {
        let texel: [u8; 4] = take(body, 4)?.try_into().expect("four bytes were taken");
        if texel[..3] == [1, 1, 1] {
            let last = *line.last().ok_or("a repeat code precedes the first texel")?;
            let count = if shift < 24 { usize::from(texel[3]) << shift } else { usize::MAX };
            if count > len - line.len() {
                return Err("a run goes past the end");
            }
            line.resize(line.len() + count, last);
            shift += 8;
        } else {
            line.push(texel);
            shift = 0;
        }
    }
    Ok(())
}
