#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/beckmann_sampling.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wo = next3();
    vec2 u = next2();
    vec2 m = next2();
    vec3 S = next3();
    float nu = next();
    at = gl_GlobalInvocationID.x * 5;
    put(beckmann_sample_visible(wo, u, m, S));
    put(visible_slope_quantile(u.x, nu));
    put(normal_quantile(u.y));
}
