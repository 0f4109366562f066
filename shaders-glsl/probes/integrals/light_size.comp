#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/light_size.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 7;
    vec3 wo = next3();
    vec3 wi = next3();
    float variance = next();
    at = gl_GlobalInvocationID.x * 5;
    vec3 S = light_slope_covariance(wo, wi, variance);
    float trace = S.x + S.y;
    put(S / trace);
    put(trace);
    put(light_normal_variance(abs(dot(wo, wi)), variance));
}
