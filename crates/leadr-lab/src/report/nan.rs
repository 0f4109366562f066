//! Reads NaN from JSON, which stores NaN as null.

use serde::{Deserialize, Deserializer};

/// Reads a number, or NaN if the value is null.
///
/// # Errors
/// Fails if the value is neither a number nor null.
pub fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
