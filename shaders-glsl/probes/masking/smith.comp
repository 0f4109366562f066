#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/smith.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 5;
    put(masking(wo, m, S));
    put(smith_lambda(wo, m, S));
    put(masking_shadowing(wo, wi, m, S, true));
    put(shadowing_given_masking(wo, wi, m, S, true));
    // Above 1.3, the fit is near 0.
    put(smith_lambda_fit(clamp(S.x, 0.001, 1.3)));
}
