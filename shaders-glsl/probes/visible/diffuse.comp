#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/diffuse.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    int terms = int(next() + 0.5);
    at = gl_GlobalInvocationID.x * 12;
    NormalMoments v;
    float light, shadowed;
    if (terms == 2) {
        v = visible_diffuse_moments(wo, m, S, 2);
        light = leadr_diffuse_light_visible(wo, wi, m, S, false, 2);
        shadowed = leadr_diffuse_light_visible(wo, wi, m, S, true, 2);
    } else {
        v = visible_diffuse_moments(wo, m, S, 3);
        light = leadr_diffuse_light_visible(wo, wi, m, S, false, 3);
        shadowed = leadr_diffuse_light_visible(wo, wi, m, S, true, 3);
    }
    put(v.mean);
    put(v.diag);
    put(v.off);
    put(light);
    put(shadowed);
    put(clamped_product(m.x, abs(S.x), m.y, abs(S.y), wi.x * S.x * S.y));
}
