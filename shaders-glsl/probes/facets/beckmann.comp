#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/beckmann.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wh = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 2;
    put(beckmann_p22(wh.xy, m, S));
    put(beckmann_ndf(wh, m, S));
}
