//! The bounds that keep every function finite. They are defined here once; the shaders use the same values.

/// Smallest slope variance; narrower distributions are treated as this wide. σ = 1e-4 is a mirror at any display
/// resolution, and its density is at most 1.6e7, far from overflow in 32 bits.
pub const MIN_VARIANCE: f64 = 1e-8;

/// Largest correlation of the two slopes: `1 − 2⁻¹³`, exact in 32 bits, so that `(1 − r)(1 + r)` is exact as well.
/// Filtering and rounding can produce exactly 1. At this bound the narrow axis of the distribution is 1.6 % of the wide
/// one.
pub const MAX_CORRELATION: f64 = 0.999_877_929_687_5;

/// Steepest mean slope (89.4°) and largest slope standard deviation. Only surfaces edge-on to their own displacement
/// direction reach it.
pub const MAX_SLOPE: f64 = 100.0;

/// Largest variance of height derivatives in any unit; the product of two is finite in 32 bits.
pub const MAX_GRADIENT_VARIANCE: f64 = 1e18;

/// Smallest visible projected area, per unit of macrosurface, used as a divisor.
pub const MIN_AREA: f64 = 1e-6;

/// Smallest z of a half vector; lower ones are treated as this high, so that `z⁻⁴` stays below 1e16.
pub const MIN_NORMAL_Z: f64 = 1e-4;

/// `x`, but at least `low`. Unlike [`f64::max`] it keeps a NaN, so that a wrong input shows in the result.
pub fn at_least(x: f64, low: f64) -> f64 {
    if x < low { low } else { x }
}

/// `x` clamped to `±bound`; NaN if either is NaN. [`f64::clamp`] panics on a NaN bound.
pub fn within(x: f64, bound: f64) -> f64 {
    if bound.is_nan() { bound } else { x.clamp(-bound, bound) }
}

/// `x` within `low..high`; `low` for a NaN.
pub(crate) fn held(x: f64, low: f64, high: f64) -> f64 {
    if x > low { x.min(high) } else { low }
}

/// `x` within 0..1; 0 for a NaN.
pub(crate) fn unit(x: f64) -> f64 {
    held(x, 0.0, 1.0)
}
