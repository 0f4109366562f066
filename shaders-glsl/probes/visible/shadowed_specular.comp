#version 460
#include "leadr/visible/shadowed_specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3(), wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float variance = next();
    at = gl_GlobalInvocationID.x * 9;
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = direction_area(wo, m, cholesky);
    for (int shadowing = LEADR_SHADOWING_SMITH; shadowing <= LEADR_SHADOWING_CORRELATED_SIMPLE; ++shadowing) {
        put(lit_probe(shadowing, o, wo, 0.04, wi, variance, m, cholesky).lit);
    }
    put(lit_probe(LEADR_SHADOWING_SMITH, o, wo, 0.04, wi, variance, m, cholesky).wi);
    for (int n = 0; n < 3; ++n) {
        int size = n == 0 ? 5 : n == 1 ? 9 : 16;
        VisibleProbes probes = visible_probes(wo, m, S, probe_kernel(size));
        o = direction_area(wo, probes.m, probes.cholesky);
        float lit = 0.0;
        for (int k = 0; k < size; ++k) {
            VisibleProbe p = visible_probe(probes, wo, probe_node(size, k, probes.wide));
            lit += p.weight * lit_probe(LEADR_SHADOWING_CORRELATED, o, wo, 1.0, p.wi, p.variance, probes.m, probes.cholesky).lit;
        }
        put(lit);
    }
}
