#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/shadowed_specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3(), wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float variance = next();
    at = gl_GlobalInvocationID.x * 12;
    VisibleProbes probes = visible_probes(LEADR_SHADOWING_SMITH, wo, m, S, probe_kernel(16));
    DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
    VisibleProbe any = VisibleProbe(vec2(0.0), wi, wi, 0.0, 0.0, variance);
    for (int shadowing = LEADR_SHADOWING_SMITH; shadowing <= LEADR_SHADOWING_CORRELATED_SIMPLE; ++shadowing) {
        put(lit_probe(shadowing, probes, o, wo, 0.04, any).lit);
    }
    LitProbe one = lit_probe(LEADR_SHADOWING_SMITH, probes, o, wo, 0.04, any);
    put(one.grazing);
    put(normalize(one.wi));
    put(probes.lit.mean);
    Horizon h = Horizon(m * 0.5, vec3(S.xy, 0.0));
    put(lit_probe(LEADR_SHADOWING_SMITH, probes, o, wo, 0.04, any, true, h).lit);
    for (int n = 0; n < 3; ++n) {
        int size = n == 0 ? 5 : n == 1 ? 9 : 16;
        probes = visible_probes(LEADR_SHADOWING_CORRELATED, wo, m, S, probe_kernel(size));
        float lit = 0.0;
        for (int k = 0; k < size; ++k) {
            VisibleProbe p = visible_probe(probes, wo, probe_node(size, k, probes.wide));
            lit += p.weight * lit_probe(LEADR_SHADOWING_CORRELATED, probes, o, wo, 1.0, p).lit;
        }
        put(lit / max(lit, 1.0));
    }
}
