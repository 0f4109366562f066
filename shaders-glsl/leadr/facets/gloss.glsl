#ifndef LEADR_GLOSS_GLSL
#define LEADR_GLOSS_GLSL

#include "../constants.glsl"

// Converts between gloss, from 0 (rough) to 1 (smooth), and the alpha of GGX. An exponential scale has alpha^2 = 2 / (c + 2^(r g + o)), and
// its curve is (c, r, o). crates/leadr-reflectance/src/facets/gloss.rs gives the sources of the scales.

const vec3 LEADR_GLOSS_ADVANCED_WARFARE = vec3(2.0, 16.0, 0.0); // Chan 2018, eq. 1
const vec3 LEADR_GLOSS_WWII = vec3(1.0, 18.0, 0.0);             // Chan 2018, eq. 2
const vec3 LEADR_GLOSS_BLINN_PHONG = vec3(2.0, 10.0, 1.0);      // exponents 2^(10 g + 1)

// Clamps a roughness to the usable range.
float usable_alpha(const float alpha) {
    return clamp(alpha, 1e-4, LEADR_MAX_SLOPE);
}

// Returns the alpha of a gloss. The gloss is clamped to 0..1.
float gloss_alpha(const float gloss, const vec3 curve) {
    float power = exp2(clamp(curve.y * clamp(gloss, 0.0, 1.0) + curve.z, -60.0, 60.0));
    return usable_alpha(sqrt(2.0 / max(curve.x + power, 1e-9)));
}

// Returns the gloss, 0..1, of an alpha. The alpha is clamped to the range of the curve.
float alpha_gloss(const float alpha, const vec3 curve) {
    float used = usable_alpha(alpha);
    float square = used * used;
    float power = max((2.0 - curve.x * square) / square, 1e-30);
    return clamp((log2(power) - curve.z) / curve.y, 0.0, 1.0);
}

// Returns alpha = (1 - g)^2, where the gloss g is one minus the perceptual roughness.
float perceptual_gloss_alpha(const float gloss) {
    float roughness = 1.0 - clamp(gloss, 0.0, 1.0);
    return usable_alpha(roughness * roughness);
}

float perceptual_alpha_gloss(const float alpha) {
    return clamp(1.0 - sqrt(usable_alpha(alpha)), 0.0, 1.0);
}

#endif
