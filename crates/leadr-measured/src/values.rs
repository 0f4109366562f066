//! Values of tables, and places between them.

use leadr_maps::MapFault;

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
