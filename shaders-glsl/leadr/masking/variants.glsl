#ifndef LEADR_MASKING_VARIANTS_GLSL
#define LEADR_MASKING_VARIANTS_GLSL

#include "correlated.glsl"
#include "grooves.glsl"
#include "../facets/projected_area.glsl"
#include "../slopes/grid.glsl"

// Computes the geometric attenuation for any slope distribution, as the factor G / a_o in f_r cos(theta_i) = F D (G / a_o) / 4 (thesis
// Table 2.IV, eq. 2.13 and 3.3; LEADR eq. 13-17). crates/leadr-reflectance/src/masking/variants.rs derives each variant.

const int LEADR_SMITH_CORRELATED = 0;    // LEADR's: a_i / (a_i A_o + a_o (A_i - a_i))
const int LEADR_SMITH_SEPARABLE = 1;     // a_i / (A_o A_i)
const int LEADR_SMITH_UNSHADOWED = 2;    // 1 / A_o
const int LEADR_SMITH_THESIS = 3;        // computed from the macrosurface's cosines, for comparison; 0 beyond its pole
const int LEADR_VGROOVE = 4;             // min(f, 2 a_o, 2 a_i) / (f a_o), f = (wo.wh) / wh.z
const int LEADR_VGROOVE_UNSHADOWED = 5;  // min(f, 2 a_o) / (f a_o)
const int LEADR_NORMAL_MAP = 6;          // 1 / f
const int LEADR_SMITH_DIRECTION_CORRELATED = 7;        // a value between LEADR's form and 1 / A_o (correlated.glsl)
const int LEADR_SMITH_DIRECTION_CORRELATED_SIMPLE = 8;

// Returns f = (wo.wh) / wh.z, the projected area, per unit of macrosurface, of the facet that reflects wo into wi. The cosine
// is computed as |wo + wi| / 2, which stays accurate as wi -> -wo.
float half_facet_area(const vec3 wo, const vec3 wi, const vec3 wh) {
    return 0.5 * length(wo + wi) / max(wh.z, 1e-12);
}

// Returns the factor G / a_o. m is the mean slope. area_o and area_i are the visible projected areas A(wo) and A(wi) of the distribution,
// clamped above MIN_AREA. S is the covariance of the slopes or a multiple of the covariance, such as a roughness matrix. Only the
// direction-correlated forms use S.
float masking_factor(const int masking, const vec3 wo, const vec3 wi, const vec3 wh, const vec2 m, float area_o, float area_i,
                     const vec3 S) {
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    area_o = max(area_o, LEADR_MIN_AREA);
    area_i = max(area_i, LEADR_MIN_AREA);
    float facet = half_facet_area(wo, wi, wh);
    if (masking == LEADR_SMITH_CORRELATED) return ai / max(ai * area_o + ao * max(area_i - ai, 0.0), 1e-30);
    if (masking == LEADR_SMITH_SEPARABLE) return ai / (area_o * area_i);
    if (masking == LEADR_SMITH_THESIS) {
        float denominator = wi.z * area_o + wo.z * area_i - wo.z * wi.z;
        bool seen = wo.z > 0.0 && wi.z > 0.0 && ao > 0.0 && ai > 0.0 && denominator > 0.0;
        return seen ? wi.z / max(denominator, LEADR_MIN_AREA * wi.z) : 0.0;
    }
    if (masking == LEADR_VGROOVE) return groove_factor(facet, ao, ai);
    if (masking == LEADR_VGROOVE_UNSHADOWED) return 1.0 / max(max(ao, 0.5 * facet), LEADR_MIN_AREA);
    if (masking == LEADR_NORMAL_MAP) return 1.0 / max(facet, LEADR_MIN_AREA);
    bool simple = masking == LEADR_SMITH_DIRECTION_CORRELATED_SIMPLE;
    if (simple || masking == LEADR_SMITH_DIRECTION_CORRELATED) {
        vec3 cholesky = slope_cholesky(S);
        vec2 po = whitened_direction(wo, cholesky);
        vec2 pi = whitened_direction(wi, cholesky);
        return masking_shadowing_factor(simple ? LEADR_SHADOWING_CORRELATED_SIMPLE : LEADR_SHADOWING_CORRELATED,
                                 DirectionArea(po, length(po), ao, area_o), DirectionArea(pi, length(pi), ai, area_i));
    }
    return 1.0 / area_o;
}

#endif
