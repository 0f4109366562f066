#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/classes.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 39;
    vec3 wo = next3();
    vec3 wi = next3();
    int classes = int(next());
    vec4 share;
    vec2 m[4];
    vec3 S[4];
    vec2 height[4];
    for (int k = 0; k < 4; ++k) {
        share[k] = next();
        m[k] = next2();
        S[k] = next3();
        height[k] = next2();
    }
    at = gl_GlobalInvocationID.x * 36;
    ClassHiding hiding = class_hiding(classes, share, m, S, height);
    put(hiding.mean);
    ClassDepths o = class_depths(hiding, wo);
    ClassDepths i = class_depths(hiding, wi);
    put(o.lambda);
    put(o.meso);
    vec4 columns[8] = vec4[](o.area, class_open(o.bend, o.depth), visible_shares(o), class_lit_fractions(LEADR_SHADOWING_NONE, o, i),
            class_lit_fractions(LEADR_SHADOWING_SMITH, o, i), class_lit_fractions(LEADR_SHADOWING_CORRELATED, o, i),
            class_lit_fractions(LEADR_SHADOWING_CORRELATED_SIMPLE, o, i), hiding.bend);
    for (int k = 0; k < 32; ++k) put(k % 4 < classes ? columns[k / 4][k % 4] : 0.0);
}
