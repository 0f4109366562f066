#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/fresnel.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = clamp_covariance(next3());
    at = gl_GlobalInvocationID.x * 3;
    put(visible_fresnel(wo, m, S, vec3(0.0, 0.04, 0.5)));
}
