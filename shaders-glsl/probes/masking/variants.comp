#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/variants.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 16;
    vec3 wo = next3();
    vec3 wi = next3();
    vec3 wh = next3();
    vec2 m = next2();
    float area_o = next();
    float area_i = next();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 9;
    for (int masking = LEADR_SMITH_CORRELATED; masking <= LEADR_SMITH_DIRECTION_CORRELATED_SIMPLE; masking++) {
        put(masking_factor(masking, wo, wi, wh, m, area_o, area_i, S));
    }
}
