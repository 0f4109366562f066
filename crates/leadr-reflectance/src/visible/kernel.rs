//! Filtered environment lookups for probes, in a cube map whose levels are blurred by a round, smooth kernel.
//!
//! Rough specular surfaces reflect the environment blurred by their lobe. A few lookups in box-filtered mips show separate boxes instead,
//! so a small lamp reveals the node pattern. In this module, level `L ≥ 1` is the environment blurred by a nearly Gaussian kernel that has
//! the same width everywhere on the sphere. The standard deviation of the kernel is [`KERNEL_TEXELS`] texels of that level at the centre of
//! a face. Level 0 is the unfiltered environment. Neighbouring lookups of these levels add up to a smooth lobe.
//!
//! Widths are *variances* per axis, in radians². A kernel of variance `v` scales the band `l` of spherical harmonics by
//! `exp(−v l (l + 1) / 2)`. Variances of successive kernels add up. A texel at the centre of a face of `size` texels is `h = 2/size` wide,
//! and bilinear lookups add `h²/6` on average, so the variance of a lookup of level `L` is
//!
//! ```text
//! V₀ = h²/4,   V_L = k 4^L h²,   k = KERNEL_TEXELS² + 1/6
//! ```
//!
//! `V₀` is the variance of a square texel plus the variance of a bilinear lookup. A fractional level mixes two kernels. [`kernel_lod`]
//! selects the fraction that gives the required variance.

/// The standard deviation of the kernel of every level except the finest, in texels of the level.
pub const KERNEL_TEXELS: f64 = 1.2;
/// The variance `k` of a lookup in a blurred level, in squared texels of the level.
pub const KERNEL_LOOKUP: f64 = KERNEL_TEXELS * KERNEL_TEXELS + 1.0 / 6.0;
/// The variance of a lookup in the finest level, in squared texels.
const FINEST_LOOKUP: f64 = 0.25;
/// The face size of the coarsest level, in texels. Its kernel has a standard deviation of 35°.
pub const COARSEST_FACE: u32 = 4;

/// Returns the number of levels of a cube with faces of `size` texels, which is at least one.
pub fn kernel_levels(size: u32) -> u32 {
    (size / COARSEST_FACE).max(1).ilog2() + 1
}

/// Returns the variance stored in level `level ≥ 1` of a cube with faces of `size` texels, without the lookup.
pub fn kernel_variance(level: u32, size: u32) -> f64 {
    let texel = KERNEL_TEXELS * 2.0 / f64::from(size) * f64::from(level).exp2();
    texel * texel
}

/// Returns the variance of a trilinear lookup at `lod`. Fractional levels interpolate the variances linearly.
pub fn lookup_variance(lod: f64, size: f64) -> f64 {
    let of = |level: f64| if level < 0.5 { FINEST_LOOKUP } else { KERNEL_LOOKUP * (2.0 * level).exp2() };
    let level = lod.floor();
    (of(level) + (lod - level) * (of(level + 1.0) - of(level))) * 4.0 / (size * size)
}

/// Returns the level of detail whose trilinear lookup has this variance per axis, in radians². `size` is the number of texels per edge of
/// the finest faces. The level is at least 0. Samplers clamp it to the last level.
pub fn kernel_lod(variance: f64, size: f64) -> f64 {
    let x = 0.25 * variance * size * size;
    let y = (x / KERNEL_LOOKUP).min(1e12);
    if y < 4.0 {
        return (x - FINEST_LOOKUP).max(0.0) / (4.0 * KERNEL_LOOKUP - FINEST_LOOKUP);
    }
    let level = (0.5 * y.log2()).floor();
    level + (y * (-2.0 * level).exp2() - 1.0) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_of_detail_has_its_designed_variance() {
        for i in 0..400 {
            let variance = 1e-5 * 1.027f64.powi(i);
            let lod = kernel_lod(variance, 256.0);
            let back = lookup_variance(lod, 256.0);
            assert!(lod >= 0.0 && (back / variance - 1.0).abs() < 1e-9 || lod == 0.0, "{variance}: {lod}, {back}");
        }
        assert!(kernel_lod(0.0, 256.0) == 0.0 && kernel_lod(f64::MAX, 256.0).is_finite());
    }

    #[test]
    fn levels_end_where_faces_are_too_small() {
        assert_eq!([1, 4, 8, 256].map(kernel_levels), [1, 1, 2, 7]);
        assert!((kernel_variance(6, 256).sqrt() - 0.6).abs() < 1e-12);
    }
}
