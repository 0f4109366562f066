#ifndef LEADR_VISIBLE_KERNEL_GLSL
#define LEADR_VISIBLE_KERNEL_GLSL

// Probes sample an environment cube map whose levels are blurred by a smooth, round kernel. The kernel has the same width everywhere on the
// sphere. The standard deviation of the kernel is LEADR_KERNEL_TEXELS texels of the level (crates/leadr-reflectance/src/visible/kernel.rs).
// Level 0 is the unblurred environment. Variances are per axis, in radians squared.

const float LEADR_KERNEL_TEXELS = 1.2;
// The variances of a bilinear lookup in a blurred level and in the finest level, in squared texels of the level.
const float LEADR_KERNEL_LOOKUP = LEADR_KERNEL_TEXELS * LEADR_KERNEL_TEXELS + 1.0 / 6.0;
const float LEADR_FINEST_LOOKUP = 0.25;

// Returns the level of detail at which a trilinear lookup has this variance. `size` is the number of texels per edge of the finest level's
// faces.
float kernel_lod(const float variance, const float size) {
    float x = 0.25 * variance * size * size;
    float y = min(x * (1.0 / LEADR_KERNEL_LOOKUP), 1e12);
    // floor(log2(y) / 2) and 4^-level are computed from the exponent bits of the float.
    int level = ((floatBitsToInt(max(y, 4.0)) >> 23) - 127) >> 1;
    float coarse = float(level) + (y * intBitsToFloat((127 - 2 * level) << 23) - 1.0) * (1.0 / 3.0);
    float fine = max(x - LEADR_FINEST_LOOKUP, 0.0) * (1.0 / (4.0 * LEADR_KERNEL_LOOKUP - LEADR_FINEST_LOOKUP));
    return y < 4.0 ? fine : coarse;
}

#endif
