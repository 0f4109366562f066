#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/statistics.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec2 first = next2();
    vec3 second = next3();
    float eta = next();
    float alpha = next();
    vec2 dx = next2();
    vec2 dy = next2();
    at = gl_GlobalInvocationID.x * 12;
    vec3 S = covariance_from_moments(first, second);
    put(S);
    put(scale_height(second, eta));
    put(add_roughness(second, alpha));
    put(add_macro_curvature(vec3(0.01, 0.02, 0.0), dx, dy));
}
