#ifndef LEADR_MICROFACET_GLSL
#define LEADR_MICROFACET_GLSL

#include "../facets/beckmann.glsl"
#include "../facets/ggx.glsl"
#include "../masking/variants.glsl"

// Evaluates f_r cos(theta_i) = D (G / a_o) / 4 of ideal facets, whose Fresnel term F is 1 (thesis eq. 2.1). For other facets, multiply by a
// Fresnel term at dot(wo, half_vector(wo, wi)). `masking` is one of the constants of masking/variants.glsl. The result is 0 for a half
// vector on or below the horizon.

// Returns the half vector of two unit directions, or zero for opposite directions.
vec3 half_vector(const vec3 wo, const vec3 wi) {
    vec3 h = wo + wi;
    return h * inversesqrt(max(dot(h, h), 1e-20));
}

// Returns D (G / a_o) / 4. The result is always finite, because D of a perfectly smooth surface is clamped to 1e30.
float microfacet_product(const float d, const float factor) {
    return 0.25 * min(d, 1e30) * factor;
}

// Evaluates the BRDF for Gaussian slopes with mean slope m and slope covariance S (s_xx, s_yy, s_xy).
float microfacet_eval_beckmann(const int masking, const vec3 wo, const vec3 wi, const vec2 m, const vec3 S) {
    vec3 wh = half_vector(wo, wi);
    if (wh.z <= 0.0) return 0.0;
    float factor = masking_factor(masking, wo, wi, wh, m, visible_area(wo, m, S), visible_area(wi, m, S), S);
    return microfacet_product(beckmann_ndf(wh, m, S), factor);
}

// Evaluates the BRDF for GGX slopes with mean slope m and roughness matrix A (a_xx, a_yy, a_xy) of alpha^2 terms.
float microfacet_eval_ggx(const int masking, const vec3 wo, const vec3 wi, const vec2 m, const vec3 A) {
    vec3 wh = half_vector(wo, wi);
    if (wh.z <= 0.0) return 0.0;
    float factor = masking_factor(masking, wo, wi, wh, m, ggx_visible_area(wo, m, A), ggx_visible_area(wi, m, A), A);
    return microfacet_product(ggx_ndf(wh, m, A), factor);
}

#endif
