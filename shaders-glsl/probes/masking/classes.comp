#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/classes.glsl"
#include "probes/leadr_probe.glsl"

vec4 next4() { vec2 a = next2(); return vec4(a, next2()); }

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 17;
    vec4 correlation = next4();
    vec4 open[2];
    vec2 whitened[2];
    for (int i = 0; i < 2; ++i) {
        open[i] = next4();
        whitened[i] = next2();
    }
    float inside = next();
    at = gl_GlobalInvocationID.x * 20;
    ClassesSeen o = ClassesSeen(open[0], whitened[0]);
    ClassesSeen i = ClassesSeen(open[1], whitened[1]);
    vec4 columns[5] = vec4[](openness_inside(open[0], inside), class_lit_fractions(LEADR_SHADOWING_NONE, correlation, o, i),
            class_lit_fractions(LEADR_SHADOWING_SMITH, correlation, o, i), class_lit_fractions(LEADR_SHADOWING_CORRELATED, correlation, o, i),
            class_lit_fractions(LEADR_SHADOWING_CORRELATED_SIMPLE, correlation, o, i));
    for (int k = 0; k < 5; ++k) { put(columns[k].xy); put(columns[k].zw); }
}
