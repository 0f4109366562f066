#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/mixed_roughness.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 3;
    vec3 means = next3();
    at = gl_GlobalInvocationID.x * 4;
    MixedRoughness mixed = mixed_roughness(means);
    put(mixed.share);
    put(mixed.smooth_alpha);
    put(mixed.rough_alpha);
    put(joint_alpha(mixed));
}
