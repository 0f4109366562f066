//! NaN in JSON, stored as null.

use serde::{Deserialize, Deserializer};

/// Reads a number; null is NaN.
///
/// # Errors
/// If it is something else.
pub fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
