#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/grazing.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 9;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    float base = next();
    at = gl_GlobalInvocationID.x * 6;
    VisibleSlopes v = visible_slopes(wo, m, S + vec3(base, base, 0.0));
    vec2 area = vec2(max(meso_area(wo, v.m), 0.0), visible_area(wo, v.m, vec3(base, base, 0.0)));
    GrazingLobe g = grazing_lobe(LEADR_SHADOWING_CORRELATED, wo, v, normalize(vec3(-0.5 * m, 1.0)), area, base);
    put(g.weight);
    put(g.weight * g.wi);
    put(g.weight * g.variance);
    put(g.weight * g.spread);
}
