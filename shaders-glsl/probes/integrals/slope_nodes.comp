#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/slope_nodes.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = clamp_covariance(next3());
    int placement = int(next());
    vec3 wi = next3();
    const int n = 5;
    at = gl_GlobalInvocationID.x * 12;
    SlopeNodes nodes = slope_nodes(placement, wo, m, S, n);
    SlopeNode node = slope_node(nodes, wo, node_row(nodes, 3), 1);
    vec2 spread = max(vec2(sqrt(S.x), sqrt(S.y)), 1e-4);
    put((node.slope - m) / spread);
    put(node.weight);
    put(log2(node.cell));
    NormalMoments v = node_normal_moments(placement, wo, m, S, n);
    put(v.mean);
    put(node_diffuse_light(placement, wo, wi, m, S, true, n));
    SlopeNode last = artificial_node(nodes, wo);
    put(log2(max(last.weight, 1e-9)));
    put(normal_of_slope(last.slope) * sign(last.weight));
}
