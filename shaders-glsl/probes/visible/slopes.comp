#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/slopes.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 14;
    VisibleSlopes v = visible_slopes(wo, m, S);
    put(v.a);
    put(v.b);
    put(v.area);
    put(v.axis);
    put(v.mean);
    put(v.cov / max(S.x + S.y, 1e-8));
    put(v.facet);
    put(v.variance);
    put(v.third);
    put(normal_ramp(m.x).ramp);
}
