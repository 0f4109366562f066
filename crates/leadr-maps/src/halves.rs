//! Slope moments as 16-bit floats, computed as `passes/surfaces/moments_store.glsl` does on the GPU.
//!
//! The variance `E[x²] − E[x]²` is computed from stored values. If the two terms are rounded independently, the variance
//! changes by up to `3 · 2⁻¹² x²`. This module corrects `E[x²]` for the rounding of the mean, so that only a third of the
//! rounding error remains.

use half::f16;

/// Returns the nearest finite 16-bit float.
pub(crate) fn half(v: f32) -> f16 {
    f16::from_f32(v.clamp(-65504.0, 65504.0))
}

/// Rounds mean slopes and second moments to 16-bit floats.
pub fn nearest(moments: [f32; 4], joint: f32) -> ([f16; 4], f16) {
    let [x, y, xx, yy] = moments;
    let [mean_x, mean_y] = [half(x), half(y)];
    let [to_x, to_y] = [mean_x.to_f32(), mean_y.to_f32()];
    let [moved_x, moved_y] = [to_x - x, to_y - y];
    let second = [xx + moved_x * (to_x + x), yy + moved_y * (to_y + y)];
    ([mean_x, mean_y, half(second[0]), half(second[1])], half(joint + x * moved_y + moved_x * to_y))
}

/// Returns a power-of-two factor for slopes. Squares of the scaled slopes fill the range of 16-bit floats (maximum 65504).
pub fn factor(steepest: f32) -> f32 {
    if steepest > 0.0 && steepest.is_finite() {
        (128.0 / steepest).log2().floor().clamp(-60.0, 60.0).exp2()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_of_second_moments_limits_variance() {
        let mut worst = [0.0f32; 2];
        for i in 0..4000 {
            let (x, y) = (0.37 + i as f32 * 0.0137, -1.9 - i as f32 * 0.0071);
            let variance = 0.01 * x * x;
            let moments = [x, y, x * x + variance, y * y + 0.01 * y * y];
            let ([mx, my, xx, yy], xy) = nearest(moments, x * y);
            let [mx, my, xx, yy, xy] = [mx, my, xx, yy, xy].map(f16::to_f32);
            let own = [
                (xx - mx * mx - variance) / (x * x),
                (yy - my * my - 0.01 * y * y) / (y * y),
                (xy - mx * my) / (x * y),
            ];
            worst[0] = own.into_iter().fold(worst[0], |a, b| a.max(b.abs()));
            let [mx, xx] = [x, x * x + variance].map(|v| f16::from_f32(v).to_f32());
            worst[1] = worst[1].max(((xx - mx * mx - variance) / (x * x)).abs());
        }
        assert!(worst[0] < 5.1e-4 && worst[1] > 1.2e-3, "{worst:?}");
    }

    #[test]
    fn squares_of_the_steepest_slope_fit() {
        for steepest in [1e-15, 0.3, 1.0, 128.0, 5e4, 1e15] {
            let scaled = steepest * factor(steepest);
            assert!(scaled <= 128.0 && scaled > 63.9, "{steepest}: {scaled}");
        }
        assert_eq!((factor(0.0), factor(f32::INFINITY)), (1.0, 1.0));
    }
}
