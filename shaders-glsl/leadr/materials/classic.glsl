#ifndef LEADR_CLASSIC_GLSL
#define LEADR_CLASSIC_GLSL

#include "../facets/beckmann.glsl"
#include "../facets/fresnel.glsl"
#include "../slopes/grid.glsl"

// Blinn-Phong lobes with mipmapped normals, after Toksvig (2005), and functions for the environment lookup of LEAN and CLEAN
// mapping. crates/leadr-reflectance/src/materials/classic.rs has the derivations.

// Returns the Blinn-Phong exponent for a Beckmann roughness, with the same curvature at the peak (Walter et al. 2007), 0 to
// 1e6.
float blinn_phong_exponent(const float alpha) {
    return clamp(2.0 / max(alpha * alpha, 1e-6) - 2.0, 0.0, 1e6);
}

// Returns the slope variance of a lobe per axis, 1 / (exponent + 2).
float blinn_phong_variance(const float exponent) {
    return 1.0 / (exponent + 2.0);
}

// Returns the density of normals per solid angle, normalised so that their projected areas sum to one.
float blinn_phong_ndf(const float cosine, const float exponent) {
    return cosine <= 0.0 ? 0.0 : (exponent + 2.0) / (2.0 * LEADR_PI) * pow(cosine, exponent);
}

// Returns the variance of unit normals about the normal of the mean slope m, per axis of its tangent plane, to first order in
// the slope covariance S.
float normal_variance(const vec2 m, const vec3 S) {
    float per = 1.0 / (1.0 + dot(m, m));
    float along = S.x * m.x * m.x + S.y * m.y * m.y + 2.0 * S.z * m.x * m.y;
    return max(0.5 * per * (S.x + S.y - per * along), 0.0);
}

// Returns (1 - |n|) / |n| of a filtered normal n, Toksvig's estimate of the variance. `variance` is the variance of Gaussian
// slopes about n.
float toksvig_variance(const float variance) {
    float shortening = tail_mean_ratio(inversesqrt(max(variance, 1e-12))); // 1 - |n|
    return shortening / max(1.0 - shortening, 1e-6);
}

// Returns the exponent of the filtered lobe.
float toksvig_exponent(const float exponent, const float variance) {
    return exponent / (1.0 + exponent * variance);
}

// Returns the level of detail of the single environment lookup for a lobe with this variance of normals per axis. size is the
// texels per edge of the cube map. Reflected directions rotate twice as far as normals.
float lobe_lod(const float variance, const float size) {
    return 0.5 * log2(max(4.0 * variance, 1e-12)) + log2(size) + 0.467;
}

#endif
