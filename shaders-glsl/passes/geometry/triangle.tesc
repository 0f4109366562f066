#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"

layout(vertices = 3) out;

layout(location = 0) in vec3 in_position[];
layout(location = 1) in vec3 in_normal[];
layout(location = 2) in flat uint in_patch[];

layout(location = 0) out vec3 out_position[];
layout(location = 1) out vec3 out_normal[];
layout(location = 2) patch out uint out_patch;

void main() {
    int i = gl_InvocationID;
    out_position[gl_InvocationID] = in_position[i];
    out_normal[gl_InvocationID] = in_normal[i];
    if (i == 0) {
        out_patch = in_patch[0];
        uvec4 edge = patches[in_patch[0]].edges >> 1;
        // The tessellator numbers each edge by the opposite corner. A triangle is stored as a patch whose third side has no length.
        vec3 factor = vec3(edge_factors[edge.y], edge_factors[edge.w], edge_factors[edge.x]);
        gl_TessLevelOuter[0] = factor.x;
        gl_TessLevelOuter[1] = factor.y;
        gl_TessLevelOuter[2] = factor.z;
        gl_TessLevelInner[0] = max(max(factor.x, factor.y), factor.z);
    }
}
