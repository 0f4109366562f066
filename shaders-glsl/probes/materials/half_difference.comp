#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/materials/half_difference.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    vec3 wo = next3();
    vec3 wi = next3();
    at = gl_GlobalInvocationID.x * 18;
    HalfDifference p = directions_to_half_difference(wo, wi);
    put(p.wh);
    put(p.wd);
    vec3 o, i;
    half_difference_to_directions(p, o, i);
    put(o);
    put(i);
    // Treats the arguments as half and difference vectors.
    half_difference_to_directions(HalfDifference(wo, wi), o, i);
    put(o);
    put(i);
}
