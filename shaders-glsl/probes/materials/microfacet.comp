#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/materials/microfacet.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 18;
    for (int masking = LEADR_SMITH_CORRELATED; masking <= LEADR_SMITH_DIRECTION_CORRELATED_SIMPLE; masking++) {
        put(microfacet_eval_beckmann(masking, wo, wi, m, S));
        put(microfacet_eval_ggx(masking, wo, wi, m, S));
    }
}
