//! Slices of isotropic materials at `φ_d = 90°` as Portable Float Maps (Chan 2018, section 5.6).
//!
//! The pixels are square steps of angle from 0° to 90°: `θ_h` along the width, `θ_d` from the bottom to the top. A pixel holds the value at
//! its centre. As a material, a slice has the same values at every `φ_d`.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::bytes::Bytes;
use super::table::Table;
use super::values::reflectance;
use leadr_maps::MapFault;
use leadr_reflectance::materials::brdf::Brdf;

/// The number of pixels along each side of a written slice.
const SIDE: usize = 90;
const MOST_SIDE: usize = 1024;

/// Whether the bytes start like a Portable Float Map.
pub fn is_slice(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PF\n") || bytes.starts_with(b"Pf\n")
}

/// Returns the values of an isotropic `brdf` in the slice, for a picture of `side` × `side` pixels, the row of the smallest `θ_d` first.
pub fn slice(brdf: &dyn Brdf, side: usize) -> Vec<DVec3> {
    let angle = |i: usize| (i as f64 + 0.5) / side as f64 * FRAC_PI_2;
    let value = |i: usize| {
        let ((sh, ch), (sd, cd)) = (angle(i % side).sin_cos(), angle(i / side).sin_cos());
        let [wo, wi] = [-1.0, 1.0].map(|side| DVec3::new(sh * cd, side * sd, ch * cd));
        brdf.eval(wo, wi)
    };
    (0..side * side).map(value).collect()
}

/// Returns the content of a file with the slice of an isotropic `brdf`.
pub fn write(brdf: &dyn Brdf) -> Vec<u8> {
    // A negative scale means little-endian numbers.
    let head = format!("PF\n{SIDE} {SIDE}\n-1.0\n");
    let values = slice(brdf, SIDE).into_iter().flat_map(|value| value.as_vec3().to_array());
    head.into_bytes().into_iter().chain(values.flat_map(f32::to_le_bytes)).collect()
}

/// Reads a slice as a table that does not depend on `φ_d`.
///
/// # Errors
/// Returns an error if the file is truncated, too large, big-endian, or has an invalid reflectance.
pub(super) fn read(bytes: &[u8]) -> Result<Table, MapFault> {
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at);
    let head = ends.nth(2).ok_or_else(|| MapFault::damaged("it has no header of three lines"))?;
    let lines = String::from_utf8_lossy(&bytes[..head]);
    let words: Vec<&str> = lines.split_whitespace().skip(1).collect();
    let [width, height, scale] = words[..] else {
        return Err(MapFault::damaged("its header has no width, height and scale"));
    };
    let [width, height] = [width, height].map(|side| side.parse().ok().filter(|side| (3..=MOST_SIDE).contains(side)));
    let (Some(width), Some(height)) = (width, height) else {
        return Err(MapFault::damaged(format!("its sides are not from 3 to {MOST_SIDE} pixels")));
    };
    if !scale.starts_with('-') {
        return Err(MapFault::unsupported("it is a big-endian PFM", "convert it to little-endian (scale -1.0)"));
    }
    let mut numbers = Bytes::new(&bytes[head + 1..]);
    let centre = |i: usize, side: usize| (i as f64 + 0.5) / side as f64 * 90.0;
    let mut rows = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut value = [0.0; 3];
        for c in 0..channels {
            let number = f32::from_bits(numbers.u32()?);
            value[c..].fill(reflectance(number.into(), || format!("pixel {x}, {y}"))?);
        }
        rows.push(([centre(x, width), centre(y, height), 0.0], DVec3::from_array(value)));
    }
    Table::from_rows(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::materials::half_difference::{HalfDifference, half_difference_to_directions};

    struct Lobe;

    /// A smooth function of both angles of the slice.
    impl Brdf for Lobe {
        fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
            let wh = (wo + wi).normalize();
            DVec3::new(wh.z.powi(40), wi.dot(wh), 0.25) * wi.z
        }
    }

    #[test]
    fn written_slices_are_read_back() {
        let bytes = write(&Lobe);
        assert!(is_slice(&bytes) && bytes.len() == 14 + 12 * SIDE * SIDE);
        let table = read(&bytes).unwrap();
        for (h, d) in [(0.5f64, 0.5f64), (10.5, 60.5), (45.5, 30.5), (89.5, 2.5)] {
            let direction =
                |theta: f64, phi: f64| DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let (wh, wd) = (direction(h.to_radians(), 0.3), direction(d.to_radians(), FRAC_PI_2));
            let (wo, wi) = half_difference_to_directions(&HalfDifference { wh, wd });
            let (want, found) = (Lobe.eval(wo, wi), table.value(wo, wi));
            assert!((want - found).length() < 1e-6 * want.length(), "{h} {d}: {found} {want}");
        }
    }

    #[test]
    fn damaged_slices_are_refused() {
        let whole = write(&Lobe);
        let with = |head: &str| [head.as_bytes(), &whole[14..]].concat();
        for (bytes, word) in [
            (whole[..whole.len() - 1].to_vec(), "ends early"),
            (b"PF\n90 90".to_vec(), "three lines"),
            (with("PF\n90 90 90\n-1.0\n"), "width, height and scale"),
            (with("PF\n90 99999\n-1.0\n"), "3 to 1024"),
            (with("PF\n90 90\n1.0\n"), "little-endian"),
            ([&whole[..14], &f32::NAN.to_le_bytes(), &whole[18..]].concat(), "pixel 0, 0 is NaN"),
        ] {
            let fault = read(&bytes).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
