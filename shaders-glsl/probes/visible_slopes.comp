#version 460
#include "leadr/visible_slopes.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 13;
    VisibleSlopes v = visible_slopes(wo, m, S);
    put(v.a);
    put(v.b);
    put(v.area);
    put(v.axis);
    put(v.mean);
    put(v.cov);
    put(v.variance);
    put(v.third);
    put(normal_ramp(m.x).ramp);
}
