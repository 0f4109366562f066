#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/beckmann.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wo = next3();
    vec3 wn = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 1;
    put(beckmann_vndf(wo, wn, m, S));
}
