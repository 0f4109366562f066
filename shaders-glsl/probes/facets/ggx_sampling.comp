#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/ggx_sampling.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 10;
    vec3 wo = next3();
    vec2 u = next2();
    vec2 m = next2();
    vec3 A = next3();
    at = gl_GlobalInvocationID.x * 3;
    put(ggx_sample_visible(wo, u, m, A));
}
