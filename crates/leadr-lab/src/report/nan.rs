//! Reads NaN from JSON, where it is stored as null.

use serde::{Deserialize, Deserializer};

/// Reads a number, with null as NaN.
///
/// # Errors
/// If the value is neither a number nor null.
pub fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
