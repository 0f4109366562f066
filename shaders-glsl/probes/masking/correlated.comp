#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/correlated.glsl"
#include "leadr/slopes/grid.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 18;
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = direction_area(wo, m, cholesky);
    DirectionArea i = direction_area(wi, m, cholesky);
    put(o.whitened);
    put(o.spread);
    put(o.meso);
    put(o.visible);
    for (int shadowing = LEADR_SHADOWING_NONE; shadowing <= LEADR_SHADOWING_VGROOVE; ++shadowing)
        put(lit_fraction(shadowing, o, i));
    put(masking_shadowing_factor(LEADR_SHADOWING_CORRELATED, o, i));
    put(masking_shadowing_factor(LEADR_SHADOWING_CORRELATED_SIMPLE, o, i));
    // Without a base, areas below LEADR_MIN_AREA occur.
    float variance = max(S.x, 1e-6);
    float Ao = visible_area(wo, m, vec3(vec2(variance), 0.0));
    for (int shadowing = LEADR_SHADOWING_SMITH; shadowing <= LEADR_SHADOWING_CORRELATED_SIMPLE; ++shadowing)
        put(round_lit_fraction(shadowing, wo, max(o.meso, 0.0), Ao, wi, m, variance));
    put(round_lit_fraction(LEADR_SHADOWING_SEPARABLE, wo, max(o.meso, 0.0), Ao, wi, m, variance));
}
