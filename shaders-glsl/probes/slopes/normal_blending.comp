#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/normal_blending.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    vec3 base = next3();
    vec3 detail = next3();
    at = gl_GlobalInvocationID.x * 18;
    put(blend_reoriented(base, detail));
    put(blend_whiteout(base, detail));
    put(blend_udn(base, detail));
    put(blend_xy(base, detail));
    put(blend_partial_derivatives(base, detail));
    put(blend_linear(base, detail));
}
