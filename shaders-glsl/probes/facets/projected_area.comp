#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/projected_area.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 10;
    put(meso_area(wo, m));
    put(slope_spread(wo, S));
    put(visible_area(wo, m, S));
    put(face_viewer(wo, m, S, 1.8));
    put(tilt_to_edge(wo, m));
    put(artificial_micronormal(wo, normalize(vec3(-m, 1.0))));
}
