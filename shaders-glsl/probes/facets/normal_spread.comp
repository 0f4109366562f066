#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/normal_spread.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 2;
    float shortening = next();
    float exponent = next();
    at = gl_GlobalInvocationID.x * 3;
    put(vmf_kappa_estimate(shortening));
    put(toksvig_factor(shortening, exponent));
    put(toksvig_normal_variance(shortening));
}
