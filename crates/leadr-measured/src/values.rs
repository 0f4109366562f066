//! Values of tables, and places between them.

use glam::DVec3;

use super::bytes::doubles;
use leadr_maps::{MapFault, limits};

/// The two indices around a place among `values`, ascending, and how far it is from the first; the ends beyond them.
pub fn bracket(values: &[f64], at: f64) -> (usize, usize, f64) {
    let last = values.len() - 1;
    let high = values.partition_point(|&v| v <= at).min(last);
    let low = high.saturating_sub(1);
    let width = values[high] - values[low];
    (low, high, if width > 0.0 { ((at - values[low]) / width).clamp(0.0, 1.0) } else { 0.0 })
}

/// A number that a table may hold: finite, not negative but for noise, and not beyond what any mirror reaches.
pub fn reflectance(value: f64, place: impl FnOnce() -> String) -> Result<f64, MapFault> {
    /// Brighter than a mirror of α = .001.
    const MOST: f64 = 1e9;
    if value.is_finite() && value <= MOST {
        Ok(value.max(0.0))
    } else {
        Err(MapFault::damaged(format!("{} is {value}, which is no reflectance", place())))
    }
}

/// Three planes of doubles, R, G and B, of as many entries each; `read` is told channel, entry and value.
pub fn planes(
    bytes: &[u8],
    entries: usize,
    read: impl Fn(usize, usize, f64) -> Result<f64, MapFault>,
) -> Result<Vec<[f32; 3]>, MapFault> {
    let mut values: Vec<[f32; 3]> = limits::zeroed(entries)?;
    for (i, value) in doubles(bytes).enumerate() {
        let (channel, entry) = (i / entries, i % entries);
        values[entry][channel] = read(channel, entry, value)? as f32;
    }
    Ok(values)
}

/// An axis of a grid: how many entries it has, the two around a place, and how far that is from the first.
pub type Axis = (usize, [usize; 2], f64);

/// The entries of a grid around a place, the last axis fastest, and their shares.
pub fn around<const N: usize>(axes: [Axis; N]) -> impl Iterator<Item = (usize, f64)> {
    (0..1usize << N).map(move |corner| {
        axes.iter().enumerate().fold((0, 1.0), |(index, share), (axis, &(entries, ends, t))| {
            let high = corner >> axis & 1;
            (index * entries + ends[high], share * if high == 1 { t } else { 1.0 - t })
        })
    })
}

/// Angle to the normal, radians.
pub fn polar(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z)
}
