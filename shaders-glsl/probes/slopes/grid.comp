#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/grid.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    int n = int(next());
    int j = int(next());
    int k = int(next());
    float lambda = next();
    at = gl_GlobalInvocationID.x * 11;
    put(grid_lambda(n));
    put(grid_spacing(n, lambda));
    vec3 node = grid_node(j, k, n, lambda);
    put(node);
    vec2 slope = slope_sample(node.xy, m, S);
    put(slope);
    put(normal_of_slope(slope));
    put(facet_area(wo, slope));
}
