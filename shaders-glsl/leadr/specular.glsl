#ifndef LEADR_SPECULAR_GLSL
#define LEADR_SPECULAR_GLSL

#include "beckmann.glsl"
#include "fresnel.glsl"
#include "masking.glsl"
#include "slope_grid.glsl"

// Radiance towards wo under one light from wi, per unit of its irradiance on a plane that faces it (LEADR eq. 17).
vec3 leadr_specular_directional(vec3 wo, vec3 wi, vec2 m, vec3 S, vec3 f0, bool shadowing) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float d = beckmann_ndf(wh, m, S);
    return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * d * masking_shadowing(wo, wi, m, S, shadowing));
}

// Environment, LEADR eq. 22 / Algorithm 1: for every grid node
//     EnvironmentSample e = environment_sample(wo, p, m, S);
//     lod = env_lod(e, S, spacing, size, LEADR_LOD_...);
//     sum += weight * e.area * fresnel_schlick(f0, dot(wo, e.wn)) * shadowing_given_masking(wo, e.wi, m, S, shadowing)
//            * textureLod(environment, world(e.wi), lod).rgb;
//     norm += weight * e.area;
// and the radiance is sum / max(norm, 1e-12). Dividing by norm is the masking term (supplement, eq. 10), so a constant
// environment gives its own value exactly. Pass m through face_viewer first: then norm is positive.

struct EnvironmentSample {
    vec3 wi;    // reflected direction, unit, tangent frame (eq. 18)
    vec3 wn;    // micronormal
    float area; // <wn, wo> / wn.z
};

EnvironmentSample environment_sample(vec3 wo, vec2 p, vec2 m, vec3 S) {
    vec2 slope = slope_sample(p, m, S);
    vec3 wn = normal_of_slope(slope);
    return EnvironmentSample(2.0 * dot(wn, wo) * wn - wo, wn, facet_area(wo, slope));
}

// Additive constants of env_lod, by where they come from.
const float LEADR_LOD_MATCHED = -0.5332;     // solid angle of the sample = mean solid angle of a cube texel
const float LEADR_LOD_SUPPLEMENT = -1.48;    // supplement 3.5, its derivation
const float LEADR_LOD_SUPPLEMENT_5 = 0.5;    // supplement 3.5, against banding with 5 x 5 nodes
const float LEADR_LOD_SUPPLEMENT_32 = -0.5;  // the same with 32 x 32
const float LEADR_LOD_ALGORITHM_1 = -1.8257; // supplement, simplified Algorithm 1: sqrt(alpha / 4 pi) textureSize

// Level of detail of a cube map of `size` texels per edge for one sample: from the solid angle J (spacing sigma)^2 with
// J = 4 |wn.wo| wn.z^3 (LEADR 5.2). May be negative; J = 0 gives a finite value.
float env_lod(vec3 wo, vec3 wn, vec3 S, float spacing, float size, float constant) {
    float jacobian = 4.0 * abs(dot(wn, wo)) * wn.z * wn.z * wn.z;
    float slope_area = max(max(S.x, S.y), 0.0) * spacing * spacing;
    return 0.5 * log2(max(jacobian * slope_area, 1e-12)) + log2(size) + constant;
}

#endif
