#ifndef LEADR_SPECULAR_GLSL
#define LEADR_SPECULAR_GLSL

#include "../facets/beckmann.glsl"
#include "../masking/correlated.glsl"
#include "../facets/fresnel.glsl"
#include "../masking/smith.glsl"
#include "../slopes/grid.glsl"

// Returns the radiance towards wo under one light from wi, per unit of irradiance on a plane that faces the light (LEADR eq.
// 17).
vec3 leadr_specular_directional(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const vec3 f0, const bool shadowing) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    if (shadowing) {
        float d = beckmann_ndf(wh, m, S);
        return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * d * masking_shadowing(wo, wi, m, S, true));
    }
    AreaQuotient o = visible_area_quotient(wo, m, S);
    return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * o.under * beckmann_ndf_over(wh, m, S, o.over));
}

// Returns the radiance under one light with any shadowing model, from the visible areas along wo (o) and wi. Compute o once per pixel and
// use it for all lights.
vec3 leadr_specular_light(const int shadowing, const DirectionArea o, const DirectionArea i, const vec3 wo, const vec3 wi, const vec2 m,
                          const vec3 S, const vec3 f0) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float d = beckmann_ndf_over(wh, m, S, max(o.visible, LEADR_MIN_AREA));
    return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * d * lit_fraction(shadowing, o, i));
}

// Evaluates an environment by LEADR eq. 22 / Algorithm 1. Once per pixel:
//     m = face_viewer(wo, m, S, lambda);            // then norm is positive
//     vec3 cholesky = slope_cholesky(S);
//     float ao = meso_area(wo, m), Ao = visible_area(wo, m, S);
//     float base = env_lod_base(S, grid_spacing(n, lambda), size, LEADR_LOD_MATCHED);
// and for every grid node
//     vec3 node = grid_node(j, k, n, lambda);
//     EnvironmentSample e = environment_sample_at(wo, slope_at(node.xy, m, cholesky));
//     float w = node.z * e.area;
//     sum += w * fresnel_schlick(f0, dot(wo, e.wn)) * (shadowing ? shadowing_from_areas(ao, Ao, e.wi, m, S) : 1.0)
//            * textureLod(environment, from_frame(f, e.wi), env_lod_at(base, wo, e.wn)).rgb;
//     norm += w;
// The radiance is sum / max(norm, 1e-12). Dividing by norm is the masking term (supplement, eq. 10), so a constant environment
// returns exactly its own value.

struct EnvironmentSample {
    vec3 wi;    // the reflected direction (eq. 18), unit length, in the tangent frame
    vec3 wn;    // micronormal
    float area; // <wn, wo> / wn.z
};

EnvironmentSample environment_sample_at(const vec3 wo, const vec2 slope) {
    vec3 wn = normal_of_slope(slope);
    return EnvironmentSample(2.0 * dot(wn, wo) * wn - wo, wn, facet_area(wo, slope));
}

// Returns the environment sample of the facet at standard normal coordinates p.
EnvironmentSample environment_sample(const vec3 wo, const vec2 p, const vec2 m, const vec3 S) {
    return environment_sample_at(wo, slope_sample(p, m, S));
}

// Additive constants of env_lod, each named after its source.
const float LEADR_LOD_MATCHED = -0.5332;     // solid angle of the sample = mean solid angle of a cube texel
const float LEADR_LOD_SUPPLEMENT = -1.48;    // from the derivation of supplement 3.5
const float LEADR_LOD_SUPPLEMENT_5 = 0.5;    // from supplement 3.5, against banding with 5 x 5 nodes
const float LEADR_LOD_SUPPLEMENT_32 = -0.5;  // from supplement 3.5, against banding with 32 x 32 nodes
const float LEADR_LOD_ALGORITHM_1 = -1.8257; // from the supplement's simplified Algorithm 1: sqrt(alpha / 4 pi) textureSize

// Computes the term of env_lod that all samples of a pixel share. size is the number of texels per edge of the cube map. spacing is the
// distance between samples in standard deviations. As in the paper, the larger standard deviation is used for both axes.
float env_lod_base(const vec3 S, const float spacing, const float size, const float constant) {
    return 0.5 * log2(max(max(S.x, S.y) * spacing * spacing, 1e-12)) + log2(size) + constant;
}

// Returns the level of detail of one sample. The solid angle of a sample is J (spacing sigma)^2 with J = 4 |wn.wo| wn.z^3 (LEADR 5.2). The
// level may be negative, and is finite even for J = 0 or sigma = 0.
float env_lod_at(const float base, const vec3 wo, const vec3 wn) {
    return base + 0.5 * log2(max(4.0 * abs(dot(wn, wo)) * wn.z * wn.z * wn.z, 1e-12));
}

float env_lod(const vec3 wo, const vec3 wn, const vec3 S, const float spacing, const float size, const float constant) {
    return env_lod_at(env_lod_base(S, spacing, size, constant), wo, wn);
}

#endif
