//! The MERL database (Matusik, Pfister, Brand and McMillan 2003).
//!
//! A file holds three planes of doubles (R, G, B) over `θ_h`, `θ_d` and `φ_d`. Entry `(i, j, k)` is at `θ_h = (i/90)² 90°`, `θ_d = j°` and
//! `φ_d = k°`. The units of R, G and B are 1/1500, 1.15/1500 and 1.66/1500. Entries for directions below the horizon are negative.
//! Interpolation uses only measured entries. Swapping the directions shifts `φ_d` by 180°, so only half a turn is stored.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::bytes::Bytes;
use super::values::{around, planes, polar, reflectance};
use leadr_maps::MapFault;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::half_difference::{
    HalfDifference, directions_to_half_difference, half_difference_to_directions,
};

/// The number of entries along each of `θ_h`, `θ_d` and `φ_d`.
const SIZE: [usize; 3] = [90, 90, 180];
const ENTRIES: usize = SIZE[0] * SIZE[1] * SIZE[2];
const BYTES: usize = 12 + 3 * 8 * ENTRIES;
const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// A material of the MERL database.
#[derive(Clone, Debug)]
pub struct Merl {
    /// The linear RGB values. Unmeasured values are negative.
    values: Vec<[f32; 3]>,
}

/// Whether the size and header match a MERL file.
pub fn is_merl(bytes: &[u8]) -> bool {
    bytes.len() == BYTES && sizes(bytes).is_ok_and(|sizes| sizes == SIZE.map(|n| n as u32))
}

fn sizes(bytes: &[u8]) -> Result<[u32; 3], MapFault> {
    let mut bytes = Bytes::new(bytes);
    Ok([bytes.u32()?, bytes.u32()?, bytes.u32()?])
}

/// Returns the reason why a file with a MERL name is not a MERL file.
pub(super) fn fault_of_start(bytes: &[u8]) -> String {
    match sizes(bytes) {
        Ok(sizes) if sizes == SIZE.map(|n| n as u32) => {
            format!("it has {} bytes; MERL files have {BYTES}", bytes.len())
        }
        Ok([a, b, c]) => format!("it declares {a} x {b} x {c} entries; MERL files have 90 x 90 x 180"),
        Err(_) => format!("it has {} bytes", bytes.len()),
    }
}

/// Returns the content of a file with the values of an isotropic `brdf` at the angles of the entries. Entries whose directions are below the
/// horizon are -1, as in the database.
pub fn write(brdf: &dyn Brdf) -> Vec<u8> {
    let [_, d, p] = SIZE;
    let value = |entry: usize| {
        let (theta_h, theta_d) = ((entry / (d * p)) as f64 / 90.0, (entry / p % d) as f64);
        let wh = direction(theta_h * theta_h * FRAC_PI_2, 0.0);
        let wd = direction(theta_d.to_radians(), ((entry % p) as f64).to_radians());
        let (wo, wi) = half_difference_to_directions(&HalfDifference { wh, wd });
        if wo.z > 0.0 && wi.z > 0.0 { brdf.eval(wo, wi) } else { DVec3::NEG_ONE }
    };
    let values: Vec<DVec3> = (0..ENTRIES).map(value).collect();
    let sizes = SIZE.iter().flat_map(|&n| (n as u32).to_le_bytes());
    let planes = (0..3).flat_map(|c| values.iter().map(move |v| v[c].max(-1.0) / SCALE[c]));
    sizes.chain(planes.flat_map(f64::to_le_bytes)).collect()
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

impl Merl {
    /// Reads a material from the content of a file.
    ///
    /// # Errors
    /// Returns an error if the size is wrong or a value is not a valid reflectance.
    pub fn read(bytes: &[u8]) -> Result<Self, MapFault> {
        if !is_merl(bytes) {
            return Err(MapFault::damaged(fault_of_start(bytes)));
        }
        let values = planes(&bytes[12..], ENTRIES, |channel, entry, value| {
            let name = || {
                let [_, d, p] = SIZE;
                let (h, d, p) = (entry / (d * p), entry / p % d, entry % p);
                format!("{} at entry {h}, {d}, {p}", ["R", "G", "B"][channel])
            };
            let scaled = SCALE[channel] * value;
            if scaled < 0.0 { Ok(-1.0) } else { reflectance(scaled, name) }
        })?;
        Ok(Self { values })
    }

    /// Returns `f_r` for two directions above the horizon.
    pub(super) fn value(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let p = directions_to_half_difference(wo, wi);
        let phi_d = p.wd.y.atan2(p.wd.x).rem_euclid(PI);
        let coordinates = [(polar(p.wh) / FRAC_PI_2).sqrt() * 90.0, polar(p.wd) / FRAC_PI_2 * 90.0, phi_d / PI * 180.0];
        let axes = [0, 1, 2].map(|axis| {
            let (coordinate, size) = (coordinates[axis], SIZE[axis]);
            let low = (coordinate.max(0.0) as usize).min(size - 1);
            // φ_d is periodic, and the other axes are clamped.
            let high = if axis == 2 { (low + 1) % size } else { (low + 1).min(size - 1) };
            (size, [low, high], (coordinate - low as f64).clamp(0.0, 1.0))
        });
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for (index, share) in around(axes) {
            let value = self.values[index];
            if share > 0.0 && value.iter().all(|&c| c >= 0.0) {
                sum += share * DVec3::from_array(value.map(f64::from));
                weight += share;
            }
        }
        if weight > 0.0 { sum / weight } else { DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measured;
    use leadr_reflectance::materials::lambert::Lambert;

    /// Returns a value that is linear along each axis, so that interpolation is exact.
    fn entry(h: f64, d: f64, p: f64) -> f64 {
        1.0 + 0.01 * h + 0.02 * d + 0.001 * p
    }

    fn file() -> Vec<u8> {
        let mut bytes: Vec<u8> = [90i32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
        for scale in SCALE {
            for i in 0..ENTRIES {
                let (h, d, p) = (i / 16_200, i / 180 % 90, i % 180);
                let value = if h == 80 { -1.0 } else { entry(h as f64, d as f64, p as f64) / scale };
                bytes.extend(value.to_le_bytes());
            }
        }
        bytes
    }

    fn directions(h: f64, d: f64, p: f64) -> (DVec3, DVec3) {
        let wh = direction((h / 90.0).powi(2) * FRAC_PI_2, 0.7);
        half_difference_to_directions(&HalfDifference { wh, wd: direction(d.to_radians(), p.to_radians()) })
    }

    /// A file of a material read from a file is the same file, but for entries below the horizon and the precision of the reader.
    #[test]
    fn written_files_are_read_back() {
        let merl = Merl::read(&file()).unwrap();
        let back = Merl::read(&write(&Measured::Merl(merl.clone()))).unwrap();
        let mut compared = 0;
        for (h, d, p) in [(3.0, 0.0, 30.0), (10.0, 20.0, 45.0), (10.5, 20.25, 90.5), (40.0, 3.0, 178.0)] {
            let (wo, wi) = directions(h, d, p);
            let (want, found) = (merl.value(wo, wi), back.value(wo, wi));
            assert!((want - found).length() < 1e-6 * want.length(), "{h} {d} {p}: {found} {want}");
            compared += usize::from(want.x > 1.0);
        }
        assert_eq!(compared, 4);
        // Some directions of the last rows are below the horizon.
        let grey = Merl::read(&write(&Lambert { albedo: DVec3::new(0.2, 0.5, 0.9) })).unwrap();
        let below = grey.values.iter().filter(|value| value[0] < 0.0).count();
        assert!((1000..ENTRIES / 2).contains(&below), "{below}");
        let (wo, wi) = directions(70.0, 30.0, 90.0);
        assert!((grey.value(wo, wi) * PI - DVec3::new(0.2, 0.5, 0.9)).length() < 1e-6);
    }

    #[test]
    fn entries_lie_at_measured_angles() {
        let mut bytes = file();
        let merl = Merl::read(&bytes).unwrap();
        for (h, d, p) in [(0.0, 0.0, 30.0), (10.0, 20.0, 45.0), (10.5, 20.25, 90.5), (40.0, 3.0, 179.0)] {
            let (wo, wi) = directions(h, d, p);
            let expected = if h == 0.0 { None } else { Some(entry(h, d, p)) };
            let found = merl.value(wo, wi);
            if let Some(expected) = expected {
                assert!((found - DVec3::splat(expected)).length() < 1e-4, "{h} {d} {p}: {found} {expected}");
            }
            // A shift of φ_d by half a turn swaps the directions.
            assert!((merl.value(wi, wo) - found).length() < 1e-6, "{h} {d} {p}");
        }
        // Unmeasured entries take the values of their measured neighbours.
        let (wo, wi) = directions(79.5, 2.0, 20.0);
        assert!((merl.value(wo, wi).x - entry(79.0, 2.0, 20.0)).abs() < 1e-4);
        let (wo, wi) = directions(80.0, 2.0, 20.0);
        assert_eq!(merl.value(wo, wi), DVec3::ZERO);

        bytes[20..28].copy_from_slice(&f64::NAN.to_le_bytes());
        let fault = Merl::read(&bytes).unwrap_err().to_string();
        assert!(fault.contains("R at entry 0, 0, 1 is NaN"), "{fault}");
        bytes.pop();
        assert!(Merl::read(&bytes).unwrap_err().to_string().contains("34992011 bytes"));
        bytes[0] = 91;
        assert!(fault_of_start(&bytes).contains("91 x 90 x 180"));
        assert!(!is_merl(&bytes[..5]) && fault_of_start(&bytes[..5]).contains("5 bytes"));
    }
}
