//! Parsers of numbers on the command line.

use std::fmt;
use std::str::FromStr;

/// Parses a finite number.
pub fn finite(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("'{text}' is not a finite number")),
    }
}

/// Parses a finite number that is above zero.
pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("must be above 0".to_owned()) })
}

/// Parses a finite number that is at least zero.
pub fn not_negative(text: &str) -> Result<f32, String> {
    finite(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("must not be negative".to_owned()) })
}

/// Parses a fraction from 0 to 1.
pub fn share(text: &str) -> Result<f32, String> {
    finite(text).and_then(|v| if (0.0..=1.0).contains(&v) { Ok(v) } else { Err("must be from 0 to 1".to_owned()) })
}

/// Parses a fraction above 0 and at most 1.
pub fn positive_share(text: &str) -> Result<f32, String> {
    let fault = || "must be above 0 and at most 1".to_owned();
    finite(text).and_then(|v| if v > 0.0 && v <= 1.0 { Ok(v) } else { Err(fault()) })
}

/// Parses a number in the range from `low` to `high`.
pub fn within<T: FromStr + PartialOrd + fmt::Display>(text: &str, low: T, high: T) -> Result<T, String> {
    in_range(text, "number", low, high)
}

/// Parses a whole number in the range from `low` to `high`.
pub fn whole<T: FromStr + PartialOrd + fmt::Display>(text: &str, low: T, high: T) -> Result<T, String> {
    in_range(text, "whole number", low, high)
}

fn in_range<T: FromStr + PartialOrd + fmt::Display>(text: &str, kind: &str, low: T, high: T) -> Result<T, String> {
    match text.parse::<T>() {
        Ok(value) if (&low..=&high).contains(&&value) => Ok(value),
        _ => Err(format!("must be a {kind} from {low} to {high}")),
    }
}

/// Parses a power of two in the range from `least` to `most`.
pub fn power_of_two(text: &str, least: u32, most: u32) -> Result<u32, String> {
    let known = || (0..32).map(|bit| 1_u32 << bit).filter(|power| (least..=most).contains(power));
    let sentence = || known().map(|power| power.to_string()).collect::<Vec<_>>().join(", ");
    text.parse()
        .ok()
        .filter(|number| known().any(|power| power == *number))
        .ok_or_else(|| format!("use one of {}", sentence()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_ends() {
        assert_eq!(within("0.1", 0.2_f32, 5.0), Err("must be a number from 0.2 to 5".to_owned()));
        assert_eq!(power_of_two("64", 8, 128), Ok(64));
        assert!(["0", "4", "65", "256", "x"].iter().all(|text| power_of_two(text, 8, 128).is_err()));
        assert!(
            within("nan", 0.0, 1.0).is_err() && within("41", 1.0, 40.0).is_err() && within("40", 1.0, 40.0).is_ok()
        );
        for outside in ["0", "-0.1", "2"] {
            assert_eq!(positive_share(outside), Err("must be above 0 and at most 1".to_owned()));
        }
        assert_eq!((positive_share("1"), positive_share("0.001")), (Ok(1.0), Ok(0.001)));
        assert!(positive("0").is_err() && not_negative("0").is_ok() && not_negative("-1").is_err());
    }
}
