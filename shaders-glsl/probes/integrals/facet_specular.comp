#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/facet_specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 13;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 cholesky = slope_cholesky(next3());
    float alpha = next();
    float variance = next();
    at = gl_GlobalInvocationID.x * 7;
    FacetSpecular f = facet_specular(wo, wi, alpha, variance);
    put(f.deviation);
    put(facet_visibility(LEADR_SHADOWING_CORRELATED, wo.z, wi.z, dot(wo, wi), f.base));
    DirectionArea o = direction_area(wo, m, cholesky), i = direction_area(wi, m, cholesky);
    for (int shadowing = 0; shadowing < 3; ++shadowing) {
        put(facet_specular_density(f, m, cholesky, shadowing));
    }
    put(facet_specular_light(LEADR_SHADOWING_CORRELATED, o, i, f, m, cholesky, vec3(0.04)).x);
}
