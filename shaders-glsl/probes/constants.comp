#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/specular.glsl"
#include "leadr_probe.glsl"

// Outputs the constants. The code reads x only to follow the probe convention.
void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x;
    float scale = next();
    at = gl_GlobalInvocationID.x * 12;
    put(scale * LEADR_PI);
    put(scale * LEADR_MIN_VARIANCE);
    put(scale * LEADR_MAX_CORRELATION);
    put(scale * LEADR_MAX_SLOPE);
    put(scale * LEADR_MAX_GRADIENT_VARIANCE);
    put(scale * LEADR_MIN_AREA);
    put(scale * LEADR_MIN_NORMAL_Z);
    put(scale * LEADR_LOD_MATCHED);
    put(scale * LEADR_LOD_SUPPLEMENT);
    put(scale * LEADR_LOD_SUPPLEMENT_5);
    put(scale * LEADR_LOD_SUPPLEMENT_32);
    put(scale * LEADR_LOD_ALGORITHM_1);
}
