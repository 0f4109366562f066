#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/base_roughness.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 9;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    float alpha = next();
    at = gl_GlobalInvocationID.x * 3;
    put(add_facet_roughness(S, alpha, wo, m));
}
