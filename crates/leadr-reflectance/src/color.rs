//! Functions for colours in linear Rec. 709 RGB.

use glam::DVec3;

/// Returns the relative luminance of a linear colour, which is 1 for white.
pub fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_one_and_green_is_most_of_it() {
        assert!((luminance(DVec3::ONE) - 1.0).abs() < 1e-15);
        assert!(luminance(DVec3::Y) > luminance(DVec3::X) && luminance(DVec3::X) > luminance(DVec3::Z));
    }
}
