//! NaN in JSON.

use serde::{Deserialize, Deserializer};

/// A number that JSON, which has no NaN, may hold as null.
///
/// # Errors
/// If it is something else.
pub fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
