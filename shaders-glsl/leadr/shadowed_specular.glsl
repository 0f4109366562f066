#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "correlated_masking.glsl"
#include "visible_specular.glsl"

// Specular environments with the shadows that the surface throws on itself, for rules with few probes
// (src/reflectance/shadowed_specular.rs). Once per pixel
//     VisibleProbes probes = visible_probes(wo, m, S);
//     DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
// and for each probe, as a factor of what it reflects,
//     float lit = probe_lit(visibility, o, p, probes.m, probes.cholesky);

// The areas that a light of this solid angle about wi sees, on average: its height above the mesosurface spread by the
// deviation of a disc, before it is cut at the horizon.
DirectionArea wide_direction_area(vec3 wi, float solid_angle, vec2 m, vec3 cholesky) {
    DirectionArea i = direction_area(wi, m, cholesky);
    float deviation = sqrt(min(solid_angle * (1.0 + dot(m, m)) * 0.0795774715, 1.0));
    float wider = rough_area(i.meso, deviation);
    i.meso = max(i.meso, 0.0) + wider;
    i.visible += wider;
    return i;
}

// Part of what the probe stands for that is lit, 0..1.
float probe_lit(int visibility, DirectionArea o, VisibleProbe p, vec2 m, vec3 cholesky) {
    if (visibility == LEADR_VISIBILITY_MASKING) return 1.0;
    return lit_fraction(visibility, o, wide_direction_area(p.wi, p.solid_angle, m, cholesky));
}

#endif
