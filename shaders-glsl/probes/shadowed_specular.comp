#version 460
#include "leadr/shadowed_specular.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3(), wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float solid_angle = next();
    at = gl_GlobalInvocationID.x * 8;
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = direction_area(wo, m, cholesky);
    DirectionArea i = wide_direction_area(wi, solid_angle, m, cholesky);
    put(i.meso);
    put(i.visible);
    VisibleProbe p = VisibleProbe(vec2(0.0), wi, 0.0, 1.0, solid_angle);
    for (int visibility = LEADR_VISIBILITY_SMITH; visibility <= LEADR_VISIBILITY_CORRELATED_SIMPLE; ++visibility) {
        put(probe_lit(visibility, o, p, m, cholesky));
    }
    VisibleProbes probes = visible_probes(wo, m, S);
    o = direction_area(wo, probes.m, probes.cholesky);
    for (int n = 0; n < 3; ++n) {
        int count = n == 0 ? 5 : n == 1 ? 9 : 16;
        float lit = 0.0;
        for (int k = 0; k < count; ++k) {
            p = visible_probe(probes, wo, probe_node(count, k));
            lit += p.weight * probe_lit(LEADR_VISIBILITY_CORRELATED, o, p, probes.m, probes.cholesky);
        }
        put(lit);
    }
}
