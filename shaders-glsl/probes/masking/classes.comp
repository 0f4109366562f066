#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/classes.glsl"
#include "probes/leadr_probe.glsl"

vec4 next4() { vec2 a = next2(); return vec4(a, next2()); }

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 33;
    vec3 correlation[4];
    for (int k = 0; k < 4; ++k) correlation[k] = next3();
    vec4 open[2];
    vec2 whitened[2];
    for (int i = 0; i < 2; ++i) {
        open[i] = next4();
        whitened[i] = next2();
    }
    float inside = next();
    vec4 components = next4();
    vec4 amounts = next4();
    at = gl_GlobalInvocationID.x * 20;
    const int models[3] = int[](LEADR_SHADOWING_NONE, LEADR_SHADOWING_SMITH, LEADR_SHADOWING_CORRELATED);
    vec4 columns[5];
    for (int k = 0; k < 4; ++k) {
        columns[0][k] = openness_inside(open[0][k], inside);
        for (int i = 0; i < 3; ++i) {
            vec2 apart = azimuths_apart(models[i], whitened[0], whitened[1]);
            columns[i + 1][k] = class_lit_fraction(models[i], apart, correlation[k], depth_inside(open[0][k], 1.0), depth_inside(open[1][k], 1.0));
        }
    }
    columns[4] = local_openness(open[0], components, amounts);
    for (int k = 0; k < 5; ++k) { put(columns[k].xy); put(columns[k].zw); }
}
