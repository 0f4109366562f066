//! Reads and interpolates table values.

use glam::DVec3;

use super::bytes::doubles;
use leadr_maps::{MapFault, limits};

/// Returns the two indices around `at` in ascending `values`, and the fraction between the two. Positions beyond the ends are clamped.
pub fn bracket(values: &[f64], at: f64) -> (usize, usize, f64) {
    let last = values.len() - 1;
    let high = values.partition_point(|&v| v <= at).min(last);
    let low = high.saturating_sub(1);
    let width = values[high] - values[low];
    (low, high, if width > 0.0 { ((at - values[low]) / width).clamp(0.0, 1.0) } else { 0.0 })
}

/// Validates a reflectance, which must be finite and at most 1e9. Negative noise becomes 0.
pub fn reflectance(value: f64, location: impl FnOnce() -> String) -> Result<f64, MapFault> {
    /// The bound is higher than the specular peak of α = 0.001.
    const MOST: f64 = 1e9;
    if value.is_finite() && value <= MOST {
        Ok(value.max(0.0))
    } else {
        Err(MapFault::damaged(format!("{} is {value}, which is not a valid reflectance", location())))
    }
}

/// Reads three planes (R, G, B) of `entries` doubles each. `read` receives the channel, entry and value.
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

/// A position along a grid axis: the number of entries, the two neighbouring entries, and the fraction between them.
pub type Axis = (usize, [usize; 2], f64);

/// Returns the grid entries around a position and their weights, for a grid whose last axis varies fastest.
pub fn around<const N: usize>(axes: [Axis; N]) -> impl Iterator<Item = (usize, f64)> {
    (0..1usize << N).map(move |corner| {
        axes.iter().enumerate().fold((0, 1.0), |(index, share), (axis, &(entries, ends, t))| {
            let high = corner >> axis & 1;
            (index * entries + ends[high], share * if high == 1 { t } else { 1.0 - t })
        })
    })
}

/// Returns the angle to the normal, in radians.
pub fn polar(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z)
}
