#ifndef LEADR_GGX_FILTERING_GLSL
#define LEADR_GGX_FILTERING_GLSL

#include "../fma.glsl"
#include "../facets/beckmann.glsl"
#include "../facets/ggx.glsl"

// Filters a GGX base of roughness matrix A on a Gaussian relief of mean slope m and slope covariance S.
// crates/leadr-reflectance/src/integrals/ggx_filtering.rs gives the exact density, and docs/measurements/ggx-filtering.md lists the errors
// of these approximations.

// Returns the roughness matrix of the single GGX lobe that approximates the surface.
vec3 filter_ggx(const vec3 A, const vec3 S) {
    return A + 2.0 * S;
}

// Returns the base's fraction of the total roughness: 0 for a perfectly smooth base, and 1 for a flat relief.
float base_share(const vec3 A, const vec3 S) {
    float base = max(fma(A.x, A.y, -A.z * A.z), 1e-30);
    float bumps = max(fma(S.x, S.y, -S.z * S.z), 0.0);
    float mixed = max(A.y * S.x + A.x * S.y - 2.0 * A.z * S.z, 0.0);
    return inversesqrt(1.0 + (2.0 * mixed + 4.0 * bumps) / base);
}

// A mixture of two surfaces. The fraction `weight` is a GGX surface of matrix `roughness`, and the rest is a Beckmann surface of covariance
// roughness / 2.
struct DisplacedGgx {
    float weight;
    vec3 roughness;
};

// Returns the mixture of the two lobes. Both constants are fitted: 0.5 makes both lobes wider than A + 2S, and 0.15 raises the weight of
// GGX above the base's fraction of the roughness.
DisplacedGgx displaced_ggx(const vec3 A, const vec3 S) {
    float t = base_share(A, S);
    float hump = sqrt(t) * (1.0 - t);
    return DisplacedGgx(min(t + 0.15 * hump * (1.0 - t), 1.0), filter_ggx(A, S) * (1.0 + 0.5 * hump));
}

// Returns the density of slopes (displaced_ggx_p22), or the density of normals D(wh) per macro area and solid angle. D is 0 for wh.z <= 0.
float displaced_ggx_p22(const vec2 slope, const vec2 m, const DisplacedGgx d) {
    return mix(beckmann_p22(slope, m, 0.5 * d.roughness), ggx_p22(slope, m, d.roughness), d.weight);
}
float displaced_ggx_ndf(const vec3 wh, const vec2 m, const DisplacedGgx d) {
    return mix(beckmann_ndf(wh, m, 0.5 * d.roughness), ggx_ndf(wh, m, d.roughness), d.weight);
}

// Returns A(w) - max(a, 0) for the mixture. `meso` is the projected area of the mesosurface.
float displaced_rough_area(const vec3 w, const float meso, const DisplacedGgx d) {
    float spread = slope_spread(w, d.roughness);
    return mix(rough_area(meso, spread * 0.70710678), ggx_rough_area(meso, spread), d.weight);
}

// Returns the visible projected area of the mixture.
float displaced_ggx_visible_area(const vec3 w, const vec2 m, const DisplacedGgx d) {
    float meso = meso_area(w, m);
    return max(meso, 0.0) + displaced_rough_area(w, meso, d);
}

// Returns 1 / (a_o (1 + Lambda_o + Lambda_i)) for the mixture (LEADR eq. 13), or 0 when the light is below the mesosurface. Without
// shadowing, the result is 1 / visible area.
float displaced_ggx_masking_shadowing(const vec3 wo, const vec3 wi, const vec2 m, const DisplacedGgx d, const bool shadowing) {
    float visible = max(displaced_ggx_visible_area(wo, m, d), LEADR_MIN_AREA);
    if (!shadowing) return 1.0 / visible;
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    return ai / max(ai * visible + ao * displaced_rough_area(wi, ai, d), 1e-30);
}

#endif
