#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/ggx_filtering.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 14;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 A = next3();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 13;
    DisplacedGgx d = displaced_ggx(A, S);
    put(filter_ggx(A, S));
    put(base_share(A, S));
    put(d.weight);
    put(d.roughness);
    put(displaced_ggx_p22(wi.xy, m, d));
    put(displaced_ggx_ndf(wi, m, d));
    put(displaced_ggx_visible_area(wo, m, d));
    put(displaced_ggx_masking_shadowing(wo, wi, m, d, true));
    put(displaced_ggx_masking_shadowing(wo, wi, m, d, false));
}
