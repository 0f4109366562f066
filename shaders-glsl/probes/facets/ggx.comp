#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/ggx.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 14;
    vec3 wo = next3();
    vec3 wi = next3();
    vec3 wn = next3();
    vec2 m = next2();
    vec3 A = next3();
    at = gl_GlobalInvocationID.x * 7;
    put(ggx_p22(wn.xy, m, A));
    put(ggx_ndf(wn, m, A));
    put(ggx_visible_area(wo, m, A));
    put(ggx_lambda(wo, m, A));
    put(ggx_masking(wo, m, A));
    put(ggx_masking_shadowing(wo, wi, m, A, true));
    put(ggx_vndf(wo, wn, m, A));
}
