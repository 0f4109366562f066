#ifndef LEADR_BASE_ROUGHNESS_GLSL
#define LEADR_BASE_ROUGHNESS_GLSL

#include "projected_area.glsl"

// Returns the covariance of the specular lobe seen from wo, on a relief of mean slope m and covariance S. Each facet has a base material of
// Beckmann roughness alpha in the facet's own frame. add_roughness is the form in the paper, where the base lies in the macrosurface's
// frame. crates/leadr-reflectance/src/facets/base_roughness.rs explains the terms and their constants.
vec3 add_facet_roughness(const vec3 S, const float alpha, const vec3 wo, const vec2 m) {
    float variance = 0.5 * alpha * alpha;
    float relief = 0.5 * (S.x + S.y);
    float facing = max(wo.z, 0.0);
    float narrowed = 6.0 * variance * facing * facing * relief * relief / (relief * relief + 0.05);
    float grazing = slope_spread(wo, S) / max(max(wo.z, meso_area(wo, m)), 0.1);
    float widened = 1.0 + 1.5 * grazing * grazing / (grazing + 1.0);
    // For |m| up to 2, the covariance of a tilted smooth facet is (1 + |m|^2) (I + m m^T) - I.
    vec2 tilt = m * min(1.0, 2.0 * inversesqrt(max(dot(m, m), 1e-12)));
    float square = dot(tilt, tilt);
    vec3 tilted = vec3(vec2(square), 0.0) + (1.0 + square) * vec3(tilt * tilt, tilt.x * tilt.y);
    return S / (1.0 + narrowed) + variance * (vec3(vec2(widened), 0.0) + tilted * (0.02 / (relief + 0.02)));
}

#endif
