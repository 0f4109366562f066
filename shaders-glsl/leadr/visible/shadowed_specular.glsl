#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "../masking/correlated.glsl"
#include "specular.glsl"

// Specular environments with the shadows that the surface casts on itself, for rules with few probes
// (src/reflectance/visible/shadowed_specular.rs). Once per pixel
//     VisibleProbes probes = visible_probes(wo, m, S);
//     DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
// and for each probe, before it is looked up,
//     LitProbe l = lit_probe(shadowing, o, p.wi, p.solid_angle, probes.m, probes.cholesky);

// Variance of the part of the lobe that a node represents, in units of its probe's variance; and the factor by which the
// lookup moves farther from the horizon than such a part.
const float LEADR_PART = 1.231;
const float LEADR_LIFT = 1.809;

struct LitProbe {
    float lit; // the lit share of the probe, 0..1
    vec3 wi;   // direction of its environment lookup, unit
};

// Light from a solid angle about wi: its height above the mesosurface is modelled as a normal variable with the deviation
// of a disc, and averaged before it is clipped at the horizon.
LitProbe lit_probe(int shadowing, DirectionArea o, vec3 wi, float solid_angle, vec2 m, vec3 cholesky) {
    if (shadowing == LEADR_SHADOWING_NONE) return LitProbe(1.0, wi);
    DirectionArea i = direction_area(wi, m, cholesky);
    float squared = 1.0 + dot(m, m);
    float deviation = sqrt(clamp((LEADR_PART * 0.0795774715) * solid_angle * squared, 1e-12, 1.0));
    NormalRamp n = normal_ramp(max(i.meso / deviation, -13.0));
    float above = deviation * n.ramp;
    i.visible += above - max(i.meso, 0.0);
    i.meso = above;
    float lift = LEADR_LIFT * deviation * n.cdf / n.ramp / squared;
    return LitProbe(lit_fraction(shadowing, o, i), normalize(wi + lift * vec3(-m, 1.0)));
}

#endif
