#ifndef LEADR_CLASSIC_GLSL
#define LEADR_CLASSIC_GLSL

#include "../facets/beckmann.glsl"
#include "../facets/fresnel.glsl"
#include "../slopes/grid.glsl"

// Blinn-Phong lobes with mipmapped normals, after Toksvig (2005), and the environment lookup of LEAN and CLEAN mapping.
// crates/leadr-reflectance/src/materials/classic.rs has the derivations.

// Returns the Blinn-Phong exponent, from 0 to 1e6, whose lobe has the same curvature at its peak as a Beckmann lobe of roughness alpha
// (Walter et al. 2007).
float blinn_phong_exponent(const float alpha) {
    return clamp(2.0 / max(alpha * alpha, 1e-6) - 2.0, 0.0, 1e6);
}

// Returns the slope variance of a lobe per axis, 1 / (exponent + 2).
float blinn_phong_variance(const float exponent) {
    return 1.0 / (exponent + 2.0);
}

// Returns the density of normals per solid angle. The density is normalised, so the projected area of all facets is one.
float blinn_phong_ndf(const float cosine, const float exponent) {
    return cosine <= 0.0 ? 0.0 : (exponent + 2.0) / (2.0 * LEADR_PI) * pow(cosine, exponent);
}

// Returns the variance of the unit normals about the normal of the mean slope m, per axis of the tangent plane. The result is exact to
// first order in the slope covariance S.
float normal_variance(const vec2 m, const vec3 S) {
    float per = 1.0 / (1.0 + dot(m, m));
    float along = S.x * m.x * m.x + S.y * m.y * m.y + 2.0 * S.z * m.x * m.y;
    return max(0.5 * per * (S.x + S.y - per * along), 0.0);
}

// Returns (1 - |n|) / |n| of a filtered normal n, Toksvig's estimate of the variance. `variance` is the variance of the Gaussian slopes
// about n.
float toksvig_variance(const float variance) {
    float shortening = tail_mean_ratio(inversesqrt(max(variance, 1e-12))); // 1 - |n|
    return shortening / max(1.0 - shortening, 1e-6);
}

// Returns the Blinn-Phong exponent of the filtered lobe.
float toksvig_exponent(const float exponent, const float variance) {
    return exponent / (1.0 + exponent * variance);
}

// Returns the level of detail for a lobe that is shaded with a single environment lookup. `variance` is the variance of normals per axis,
// and `size` is the number of texels per edge of the cube map. Reflected directions rotate by twice the angle of the normals.
float lobe_lod(const float variance, const float size) {
    return 0.5 * log2(max(4.0 * variance, 1e-12)) + log2(size) + 0.467;
}

#endif
