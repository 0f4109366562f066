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
    at = gl_GlobalInvocationID.x * 6;
    vec3 f0 = vec3(0.0, 0.04, 0.5);
    put(visible_fresnel(wo, m, S, f0));
    put(visible_fresnel_exact(wo, m, S, f0, complex_index(f0, vec3(0.0, 0.0, 3.0))));
}
