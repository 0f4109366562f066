//! Numerical bounds that keep every function finite. The shaders use the same values.

/// Smallest slope variance; narrower distributions are widened to it. σ = 1e-4 is a perfect mirror at any display resolution. Its density
/// is at most 1.6e7, far from overflow in 32 bits.
pub const MIN_VARIANCE: f64 = 1e-8;

/// Largest correlation of the two slopes: `1 − 2⁻¹³`. In 32 bits this and `(1 − r)(1 + r)` are exact. Filtering and rounding can produce
/// exactly 1. At this bound the minor axis of the distribution is 1.6 % of the major one.
pub const MAX_CORRELATION: f64 = 0.999_877_929_687_5;

/// Steepest mean slope (89.4°) and largest slope standard deviation. Only surfaces edge-on to their own displacement direction reach them.
pub const MAX_SLOPE: f64 = 100.0;

/// Largest variance of height derivatives in any unit; the product of two is finite in 32 bits.
pub const MAX_GRADIENT_VARIANCE: f64 = 1e18;

/// Smallest visible projected area, per unit of macrosurface, used as a divisor.
pub const MIN_AREA: f64 = 1e-6;

/// Smallest z of a half vector; smaller values are raised to it, so `z⁻⁴` stays below 1e16.
pub const MIN_NORMAL_Z: f64 = 1e-4;

/// `x`, but at least `low`. Unlike [`f64::max`] it propagates NaN, so that a wrong input shows in the result.
pub fn at_least(x: f64, low: f64) -> f64 {
    if x < low { low } else { x }
}

/// `x` clamped to `±bound`; NaN if either is NaN. [`f64::clamp`] panics on a NaN bound.
pub fn within(x: f64, bound: f64) -> f64 {
    if bound.is_nan() { bound } else { x.clamp(-bound, bound) }
}

/// `x` clamped to `low..high`; `low` for NaN.
pub(crate) fn held(x: f64, low: f64, high: f64) -> f64 {
    if x > low { x.min(high) } else { low }
}

/// `x` clamped to 0..1; 0 for NaN.
pub(crate) fn unit(x: f64) -> f64 {
    held(x, 0.0, 1.0)
}
