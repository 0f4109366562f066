#version 460
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"

layout(vertices = 4) out;

layout(location = 0) in vec3 in_rest[];
layout(location = 1) in flat uint in_patch[];

layout(location = 0) out vec3 out_rest[];
layout(location = 1) patch out uint out_patch;

void main() {
    out_rest[gl_InvocationID] = in_rest[gl_InvocationID];
    if (gl_InvocationID == 0) {
        out_patch = in_patch[0];
        uvec4 edge = patch_edges[in_patch[0]] >> 1;
        vec4 factor = vec4(edge_factors[edge.x], edge_factors[edge.y], edge_factors[edge.z], edge_factors[edge.w]);
        gl_TessLevelOuter[0] = factor.w;
        gl_TessLevelOuter[1] = factor.x;
        gl_TessLevelOuter[2] = factor.y;
        gl_TessLevelOuter[3] = factor.z;
        gl_TessLevelInner[0] = max(factor.x, factor.z);
        gl_TessLevelInner[1] = max(factor.y, factor.w);
    }
}
