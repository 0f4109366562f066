//! The transfer function of sRGB (IEC 61966-2-1).

use std::sync::LazyLock;

/// Returns the display code of a linear value, from 0 to 1. The value is clamped to 0..1.
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the linear value of a display code. Inverse of [`srgb_from_linear`].
pub fn linear_from_srgb(code: f32) -> f32 {
    let code = code.clamp(0.0, 1.0);
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Returns the nearest 8-bit display code of a linear value. The value is clamped to 0..1.
pub fn srgb8_from_linear(x: f32) -> u8 {
    let (codes, x) = (&*CODES, x.clamp(0.0, 1.0));
    let code = codes.first[((x * STEPS as f32) as usize).min(STEPS - 1)];
    code + u8::from(code < u8::MAX && x >= codes.least[usize::from(code) + 1])
}

/// The conversion table. Without the table, a `powf` for every channel of every texel would dominate the time to save.
static CODES: LazyLock<Codes> = LazyLock::new(Codes::new);

/// The number of linear intervals in the table. No interval spans more than two codes.
const STEPS: usize = 4096;

struct Codes {
    least: [f32; 256],
    first: [u8; STEPS],
}

impl Codes {
    fn new() -> Self {
        let code = |x: f32| (srgb_from_linear(x) * 255.0 + 0.5) as u8;
        // Positive floats have the same order as their bit patterns.
        let least = |wanted: usize| {
            let (mut below, mut above) = (0u32, 1f32.to_bits());
            while above - below > 1 {
                let middle = below.midpoint(above);
                if usize::from(code(f32::from_bits(middle))) >= wanted { above = middle } else { below = middle }
            }
            f32::from_bits(above)
        };
        Self {
            least: std::array::from_fn(|wanted| if wanted == 0 { 0.0 } else { least(wanted) }),
            first: std::array::from_fn(|step| code(step as f32 / STEPS as f32)),
        }
    }
}

/// Returns the linear values of the 256 display codes.
pub fn linear_of_srgb8() -> [f32; 256] {
    std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_curve() {
        let of_curve = |x: f32| (srgb_from_linear(x) * 255.0 + 0.5) as u8;
        for i in 0..=2_000_000u32 {
            let x = i as f32 / 2e6 * 1.02 - 0.01;
            assert_eq!(srgb8_from_linear(x), of_curve(x), "{x}");
        }
        // The test covers both sides of every code boundary.
        for least in CODES.least.into_iter().skip(1) {
            for x in [least.next_down(), least, least.next_up()] {
                assert_eq!(srgb8_from_linear(x), of_curve(x), "{x}");
            }
        }
        assert_eq!(
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(srgb8_from_linear),
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(of_curve)
        );
    }

    #[test]
    fn srgb_round_trips_every_code() {
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f32::from(code) / 255.0);
            assert_eq!((srgb_from_linear(linear) * 255.0).round() as u8, code);
        }
        // The expected values are middle grey and white from the standard.
        assert!((srgb_from_linear(0.214_041_14) - 0.5).abs() < 1e-5);
        assert!((srgb_from_linear(1.0) - 1.0).abs() < 1e-6);
    }
}
