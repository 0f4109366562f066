//! The UTIA database of anisotropic materials (Filip and Vávra 2014).
//!
//! A file holds three planes of doubles (R, G, B) over `θ` and `φ` of the light and of the viewer. `θ` has steps of 15° up to 75°, and `φ`
//! has steps of 7.5°. The viewer's `φ` varies fastest. A value is 140 times the sRGB code of `f_r / 100`. As in the database's own
//! programs, values are interpolated before they are decoded. Beyond 75°, values are extrapolated from 60° and 75°. The few negative values
//! become 0.

use glam::DVec3;

use super::values::{Axis, around, planes, polar, reflectance};
use leadr_maps::MapFault;

const THETAS: usize = 6;
const PHIS: usize = 48;
const ENTRIES: usize = THETAS * PHIS * THETAS * PHIS;
/// The file length in bytes.
pub const BYTES: usize = 3 * 8 * ENTRIES;
const UNIT: f64 = 1.0 / 140.0;
/// The value of `f_r` for the largest code.
const SCALE: f64 = 100.0;

/// A material of the UTIA database.
#[derive(Clone, Debug)]
pub struct Utia {
    /// The sRGB codes of the entries.
    values: Vec<[f32; 3]>,
}

impl Utia {
    /// Reads a material from the content of a file.
    ///
    /// # Errors
    /// Returns an error if the length is wrong or a value is not a number.
    pub fn read(bytes: &[u8]) -> Result<Self, MapFault> {
        if bytes.len() != BYTES {
            return Err(MapFault::damaged(format!("it has {} bytes instead of {BYTES}", bytes.len())));
        }
        let values = planes(bytes, ENTRIES, |channel, entry, value| {
            reflectance(value * UNIT, || format!("{} of entry {entry}", ["R", "G", "B"][channel]))
        })?;
        Ok(Self { values })
    }

    /// Returns `f_r` for two directions above the horizon.
    pub(super) fn value(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let mut code = DVec3::ZERO;
        for (index, share) in around([theta(wi), phi(wi), theta(wo), phi(wo)]) {
            code += share * DVec3::from_array(self.values[index].map(f64::from));
        }
        SCALE * DVec3::new(decode(code.x), decode(code.y), decode(code.z))
    }
}

fn theta(w: DVec3) -> Axis {
    let at = polar(w).to_degrees() / 15.0;
    let low = (at as usize).min(THETAS - 2);
    (THETAS, [low, low + 1], at - low as f64)
}

fn phi(w: DVec3) -> Axis {
    let at = w.y.atan2(w.x).to_degrees().rem_euclid(360.0) / 7.5;
    let low = (at as usize).min(PHIS - 1);
    (PHIS, [low, (low + 1) % PHIS], at - low as f64)
}

/// Converts an sRGB code to a linear value. The curve continues above 1.
fn decode(code: f64) -> f64 {
    if code <= 0.0 {
        0.0
    } else if code <= 0.04045 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(theta: f64, phi: f64) -> DVec3 {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    #[test]
    fn entries_lie_at_measured_angles() {
        let code = |ti: f64, pi: f64, tv: f64, pv: f64| 0.1 + 0.003 * ti + 0.0002 * pi + 0.001 * tv + 0.0004 * pv;
        let mut bytes = Vec::new();
        for channel in 0..3 {
            for i in 0..ENTRIES {
                let (ti, pi, tv, pv) =
                    (i / PHIS / THETAS / PHIS, i / PHIS / THETAS % PHIS, i / PHIS % THETAS, i % PHIS);
                let at = code(15.0 * ti as f64, 7.5 * pi as f64, 15.0 * tv as f64, 7.5 * pv as f64);
                bytes.extend((140.0 * at / f64::from(channel + 1)).to_le_bytes());
            }
        }
        assert_eq!(bytes.len(), BYTES);
        let utia = Utia::read(&bytes).unwrap();
        for (ti, pi, tv, pv) in [(0.0, 30.0, 15.0, 60.0), (20.0, 100.0, 40.0, 3.0), (74.0, 200.0, 80.0, 351.0)] {
            let found = utia.value(direction(tv, pv), direction(ti, pi));
            // A direction along the normal has the azimuth 0.
            let expected = code(ti, if ti == 0.0 { 0.0 } else { pi }, tv, pv);
            assert!((found.x - SCALE * decode(expected)).abs() < 1e-3 * found.x, "{found} {expected}");
            assert!((found.z - SCALE * decode(expected / 3.0)).abs() < 1e-3 * found.z);
        }
        bytes[8..16].copy_from_slice(&(-3.0f64).to_le_bytes());
        assert_eq!(Utia::read(&bytes).unwrap().values[1][0], 0.0, "noise below zero");
        bytes[8..16].copy_from_slice(&f64::INFINITY.to_le_bytes());
        assert!(Utia::read(&bytes).unwrap_err().to_string().contains("R of entry 1"));
        assert!(Utia::read(&bytes[1..]).is_err());
    }

    #[test]
    fn codes_are_those_of_the_screen() {
        assert!((decode(0.04045) - 0.04045 / 12.92).abs() < 1e-9 && (decode(1.0) - 1.0).abs() < 1e-12);
        assert_eq!(decode(-1.0), 0.0);
        assert!(decode(2.0) > 4.0);
    }
}
