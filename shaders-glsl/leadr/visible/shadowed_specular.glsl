#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "../masking/correlated.glsl"
#include "specular.glsl"

// Specular environments with the shadows that the surface casts on itself, for rules with few probes
// (src/reflectance/visible/shadowed_specular.rs). Once per pixel
//     VisibleProbes probes = visible_probes(wo, m, S, probe_kernel(n));
//     DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
// and for each probe, before it is looked up,
//     LitProbe l = lit_probe(shadowing, o, wo, f0, p.wi, p.variance, probes.m, probes.cholesky);

struct LitProbe {
    float lit;       // the lit share of the probe, 0..1
    vec3 wi;         // direction of its environment lookup, unit
    float narrowing; // factor of that lookup's variance, 0.5..1
};

// Light of this variance about wi: the mean of the lit fractions one deviation above it and below it, as seen from
// the mesosurface, weighted by Schlick's term of f0. The lookup moves and narrows to the lit part.
LitProbe lit_probe(int shadowing, DirectionArea o, vec3 wo, float f0, vec3 wi, float variance, vec2 m, vec3 cholesky) {
    if (shadowing == LEADR_SHADOWING_NONE) return LitProbe(1.0, wi, 1.0);
    vec3 up = vec3(-m, 1.0) * inversesqrt(1.0 + dot(m, m));
    float height = dot(up, wi);
    float side = sqrt(max(1.0 - height * height, 0.0));
    float per_side = 1.0 / max(side, 1e-4);
    float cosine2 = 1.0 / (1.0 + variance);
    float sine = sqrt(variance * cosine2);
    vec2 heights = height * cosine2 + vec2(side * sine, -side * sine);
    vec2 sides = per_side * sqrt(max(1.0 - heights * heights, 0.0));
    vec3 flat_wi = wi - up * height;
    vec3 above = up * heights.x + flat_wi * sides.x;
    vec3 below = up * heights.y + flat_wi * sides.y;
    // What grazes is both brighter and more often hidden.
    vec2 k = 1.0 - sqrt(clamp(0.5 + 0.5 * vec2(dot(wo, above), dot(wo, below)), 0.0, 1.0));
    vec2 fresnel = f0 + (1.0 - f0) * (k * k) * (k * k) * k;
    float high = fresnel.x * lit_fraction(shadowing, o, direction_area(above, m, cholesky));
    float low = fresnel.y * lit_fraction(shadowing, o, direction_area(below, m, cholesky));
    float lit = (high + low) / max(fresnel.x + fresnel.y, 1e-6);
    float bias = (high - low) / max(high + low, 1e-6);
    vec3 towards = wi * sqrt(cosine2) + (up - wi * height) * (per_side * bias * sine);
    return LitProbe(lit, normalize(towards), 1.0 - 0.5 * bias * bias);
}

#endif
