#ifndef LEADR_GGX_GLSL
#define LEADR_GGX_GLSL

#include "projected_area.glsl"
#include "slope_distribution.glsl"
#include "../slopes/statistics.glsl"

// The noncentral GGX distribution with a full roughness matrix A = (a_xx, a_yy, a_xy) of alpha^2 terms (thesis Table 2.II, eq.
// 3.2; IGSA supplement 1). m is the mean slope. crates/leadr-reflectance/src/facets/ggx.rs has the derivations.

// Returns (1 / sqrt(a_xx), 1 / sqrt(a_yy), r, 1 / sqrt(1 - r^2)). The diagonal elements of A are raised to at least MIN_VARIANCE. r is the
// correlation, whose magnitude is below 1.
vec4 ggx_whitening(const vec3 A) {
    vec2 alpha = sqrt(clamp(A.xy, LEADR_MIN_VARIANCE, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE));
    float r = slope_correlation(alpha, A.z);
    return vec4(1.0 / alpha, r, inversesqrt((1.0 - r) * (1.0 + r)));
}

// Returns P22(slope), the density of slopes. Diagonal elements of A are raised to at least MIN_VARIANCE.
float ggx_p22(const vec2 slope, const vec2 m, const vec3 A) {
    vec4 k = ggx_whitening(A);
    vec2 u = (slope - m) * k.xy;
    float v = (u.y - k.z * u.x) * k.w;
    float g = 1.0 / (1.0 + u.x * u.x + v * v);
    return g * g * (k.x * k.y * k.w) / LEADR_PI;
}

// Returns D(wh) = P22(slope of wh) / wh.z^4 = 1 / (pi sqrt|A| (z^2 + d^2)^2), where d is the whitened vector -wh.xy - wh.z m. The result is
// 0 for wh.z <= 0.
float ggx_ndf(const vec3 wh, const vec2 m, const vec3 A) {
    if (wh.z <= 0.0) return 0.0;
    vec4 k = ggx_whitening(A);
    vec2 u = (-wh.xy - wh.z * m) * k.xy;
    float v = (u.y - k.z * u.x) * k.w;
    float g = 1.0 / max(wh.z * wh.z + u.x * u.x + v * v, 1e-13);
    return g * g * (k.x * k.y * k.w) / LEADR_PI;
}

// Returns A(w) - max(a, 0) = b^2 / (2 (|a| + sqrt(a^2 + b^2))), the area that is visible only because of the roughness.
float ggx_rough_area(const float a, const float b) {
    // The larger of |a| and b is factored out of the root, so that no square overflows or underflows.
    float top = max(max(abs(a), b), 1e-18);
    vec2 q = vec2(a, b) / top;
    return 0.5 * b * (b / max(abs(a) + top * length(q), 1e-18));
}

// Returns A(w) = (a + sqrt(a^2 + b^2)) / 2, the visible projected area, whether the mesosurface faces the viewer or not.
float ggx_visible_area(const vec3 w, const vec2 m, const vec3 A) {
    float a = meso_area(w, m);
    return max(a, 0.0) + ggx_rough_area(a, slope_spread(w, A));
}

// Returns Lambda(w) = (sqrt(1 + b^2/a^2) - 1) / 2, or a large finite value where the formula gives +infinity (a <= 0).
float ggx_lambda(const vec3 w, const vec2 m, const vec3 A) {
    float a = meso_area(w, m);
    return ggx_rough_area(a, slope_spread(w, A)) / max(a, LEADR_MIN_AREA);
}

// Returns 1 / A(wo), the factor of masking without shadowing, with the projected area of LEADR eq. 16.
float ggx_masking(const vec3 wo, const vec2 m, const vec3 A) {
    return 1.0 / max(ggx_visible_area(wo, m, A), LEADR_MIN_AREA);
}

// Returns 1 / (a_o (1 + Lambda_o + Lambda_i)), LEADR eq. 13 with the Lambda of GGX, or 0 when the light is below the
// mesosurface. Without shadowing, the result is ggx_masking.
float ggx_masking_shadowing(const vec3 wo, const vec3 wi, const vec2 m, const vec3 A, const bool shadowing) {
    if (!shadowing) return ggx_masking(wo, m, A);
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    float Ao = max(ggx_visible_area(wo, m, A), LEADR_MIN_AREA);
    return ai / max(ai * Ao + ao * ggx_rough_area(ai, slope_spread(wi, A)), 1e-30);
}

// Returns the density of visible normals, max(0, wo.wn) D(wn) / A(wo), per solid angle, at most 1e37.
float ggx_vndf(const vec3 wo, const vec3 wn, const vec2 m, const vec3 A) {
    return visible_density(wo, wn, ggx_ndf(wn, m, A), ggx_visible_area(wo, m, A));
}

#endif
