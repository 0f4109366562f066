#ifndef LEADR_GGX_FILTERING_GLSL
#define LEADR_GGX_FILTERING_GLSL

#include "../fma.glsl"
#include "../facets/beckmann.glsl"
#include "../facets/ggx.glsl"

// A GGX base of roughness matrix A under Gaussian displacement of mean slope m and covariance S.
// crates/leadr-reflectance/src/integrals/ggx_filtering.rs gives the exact density, docs/measurements/ggx-filtering.md the
// errors of these approximations.

// Approximation by one GGX lobe.
vec3 filter_ggx(const vec3 A, const vec3 S) {
    return A + 2.0 * S;
}

// Share of the base in the total roughness: 0 for a perfectly smooth base, 1 for a flat relief.
float base_share(const vec3 A, const vec3 S) {
    float base = max(fma(A.x, A.y, -A.z * A.z), 1e-30);
    float bumps = max(fma(S.x, S.y, -S.z * S.z), 0.0);
    float mixed = max(A.y * S.x + A.x * S.y - 2.0 * A.z * S.z, 0.0);
    return inversesqrt(1.0 + (2.0 * mixed + 4.0 * bumps) / base);
}

// A mixture: the share `weight` is a GGX surface of matrix `roughness`, the rest a Beckmann surface of covariance roughness /
// 2.
struct DisplacedGgx {
    float weight;
    vec3 roughness;
};

// The two lobes; the constants are a fit (0.5: both are wider than A + 2S; 0.15: more GGX than the base's share).
DisplacedGgx displaced_ggx(const vec3 A, const vec3 S) {
    float t = base_share(A, S);
    float hump = sqrt(t) * (1.0 - t);
    return DisplacedGgx(min(t + 0.15 * hump * (1.0 - t), 1.0), filter_ggx(A, S) * (1.0 + 0.5 * hump));
}

// Density of slopes, and D(wh) per macro area and solid angle (0 for wh.z <= 0).
float displaced_ggx_p22(const vec2 slope, const vec2 m, const DisplacedGgx d) {
    return mix(beckmann_p22(slope, m, 0.5 * d.roughness), ggx_p22(slope, m, d.roughness), d.weight);
}
float displaced_ggx_ndf(const vec3 wh, const vec2 m, const DisplacedGgx d) {
    return mix(beckmann_ndf(wh, m, 0.5 * d.roughness), ggx_ndf(wh, m, d.roughness), d.weight);
}

// A(w) - max(a, 0) of the mixture; `meso`: the projected area of its mesosurface.
float displaced_rough_area(const vec3 w, const float meso, const DisplacedGgx d) {
    float spread = slope_spread(w, d.roughness);
    return mix(rough_area(meso, spread * 0.70710678), ggx_rough_area(meso, spread), d.weight);
}

// Visible projected area of the mixture.
float displaced_ggx_visible_area(const vec3 w, const vec2 m, const DisplacedGgx d) {
    float meso = meso_area(w, m);
    return max(meso, 0.0) + displaced_rough_area(w, meso, d);
}

// 1 / (a_o (1 + Lambda_o + Lambda_i)) of the mixture (LEADR eq. 13); 0 when the light is below the mesosurface. Without
// shadowing: 1 / visible area.
float displaced_ggx_masking_shadowing(const vec3 wo, const vec3 wi, const vec2 m, const DisplacedGgx d, const bool shadowing) {
    float visible = max(displaced_ggx_visible_area(wo, m, d), LEADR_MIN_AREA);
    if (!shadowing) return 1.0 / visible;
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    return ai / max(ai * visible + ao * displaced_rough_area(wi, ai, d), 1e-30);
}

#endif
