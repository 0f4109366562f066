//! Numerical bounds that keep every function finite. The shaders use the same values.

/// The smallest slope variance. Narrower distributions are widened to this variance. A surface with this variance (σ = 1e-4) is a perfect
/// mirror at any display resolution. Its slope density is at most 1.6e7, far from overflow in 32 bits.
pub const MIN_VARIANCE: f64 = 1e-8;

/// The largest correlation `r` of the two slopes, `1 − 2⁻¹³`. In 32 bits, `r` and `(1 − r)(1 + r)` are exact. Filtering and rounding can
/// produce a correlation of exactly 1. At this bound, the minor axis of the distribution is at most 0.8 % of the major axis.
pub const MAX_CORRELATION: f64 = 0.999_877_929_687_5;

/// The upper limit of the mean slope (89.4°) and of the slope deviation. Only surfaces edge-on to their own displacement direction reach
/// this bound.
pub const MAX_SLOPE: f64 = 100.0;

/// The largest variance of height derivatives in any unit. The product of two such variances is finite in 32 bits.
pub const MAX_GRADIENT_VARIANCE: f64 = 1e18;

/// The smallest visible projected area, per unit of macrosurface, that is used as a divisor.
pub const MIN_AREA: f64 = 1e-6;

/// The smallest z of a half vector. Smaller values are raised to this bound, so `z⁻⁴` is at most 1e16.
pub const MIN_NORMAL_Z: f64 = 1e-4;

/// Returns `x`, but at least `low`. Unlike [`f64::max`], the function propagates NaN, so that a wrong input shows in the result.
pub fn at_least(x: f64, low: f64) -> f64 {
    if x < low { low } else { x }
}

/// Clamps `x` to `±bound`, or returns NaN if `x` or `bound` is NaN. [`f64::clamp`] panics on a NaN bound.
pub fn within(x: f64, bound: f64) -> f64 {
    if bound.is_nan() { bound } else { x.clamp(-bound, bound) }
}

/// Clamps `x` to `low..high`, and returns `low` for NaN.
pub(crate) fn held(x: f64, low: f64, high: f64) -> f64 {
    if x > low { x.min(high) } else { low }
}

/// Clamps `x` to 0..1, and returns 0 for NaN.
pub(crate) fn unit(x: f64) -> f64 {
    held(x, 0.0, 1.0)
}
