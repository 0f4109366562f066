#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/fresnel.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 7;
    vec3 eta = next3();
    vec3 k = next3();
    float cosine = next();
    at = gl_GlobalInvocationID.x * 3;
    put(fresnel_conductor(cosine, eta, k));
}
