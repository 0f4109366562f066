#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "../masking/correlated.glsl"
#include "specular.glsl"

// Specular environments with the shadows that the surface casts on itself, for rules with few probes
// (src/reflectance/visible/shadowed_specular.rs). Once per pixel
//     VisibleProbes probes = visible_probes(wo, m, S, probe_kernel(n));
//     DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
// and for each probe, before it is looked up,
//     LitProbe l = lit_probe(shadowing, o, p.wi, p.variance, probes.m, probes.cholesky);

struct LitProbe {
    float lit;       // the lit share of the probe, 0..1
    vec3 wi;         // direction of its environment lookup, unit
    float narrowing; // factor of that lookup's variance, 0.5..1
};

// Light of this variance about wi: the mean of the lit fractions one deviation above it and below it, as seen from
// the mesosurface. The lookup moves and narrows to the lit part.
LitProbe lit_probe(int shadowing, DirectionArea o, vec3 wi, float variance, vec2 m, vec3 cholesky) {
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
    float high = lit_fraction(shadowing, o, direction_area(up * heights.x + flat_wi * sides.x, m, cholesky));
    float low = lit_fraction(shadowing, o, direction_area(up * heights.y + flat_wi * sides.y, m, cholesky));
    float lit = 0.5 * (high + low);
    float bias = 0.5 * (high - low) / max(lit, 1e-6);
    vec3 towards = wi * sqrt(cosine2) + (up - wi * height) * (per_side * bias * sine);
    return LitProbe(lit, normalize(towards), 1.0 - 0.5 * bias * bias);
}

#endif
