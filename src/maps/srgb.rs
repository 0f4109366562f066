//! The transfer function of sRGB (IEC 61966-2-1).

/// Display code 0 to 1 from linear 0 to 1. Clamps outside.
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Inverse of [`srgb_from_linear`] on 0 to 1.
pub fn linear_from_srgb(code: f32) -> f32 {
    let code = code.clamp(0.0, 1.0);
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// The nearest 8-bit display code of a linear value in 0 to 1. Clamps outside.
pub fn srgb8_from_linear(x: f32) -> u8 {
    (srgb_from_linear(x) * 255.0 + 0.5) as u8
}

/// Linear values of the 256 display codes.
pub fn linear_of_srgb8() -> [f32; 256] {
    std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_every_code() {
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f32::from(code) / 255.0);
            assert_eq!((srgb_from_linear(linear) * 255.0).round() as u8, code);
        }
        // Middle grey and white by the standard's own numbers.
        assert!((srgb_from_linear(0.214_041_14) - 0.5).abs() < 1e-5);
        assert!((srgb_from_linear(1.0) - 1.0).abs() < 1e-6);
    }
}
