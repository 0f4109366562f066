#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"

layout(vertices = 4) out;

layout(location = 0) in vec3 in_position[];
layout(location = 1) in vec3 in_normal[];
layout(location = 2) in flat uint in_patch[];

layout(location = 0) out vec3 out_position[];
layout(location = 1) out vec3 out_normal[];
layout(location = 2) out vec3 out_toward_next[]; // inner Bezier points on the two boundaries at this corner
layout(location = 3) out vec3 out_toward_previous[];
layout(location = 4) patch out uint out_patch;

void main() {
    int i = gl_InvocationID;
    out_position[gl_InvocationID] = in_position[i];
    out_normal[gl_InvocationID] = in_normal[i];
    out_toward_next[gl_InvocationID] = edge_point(in_position[i], in_normal[i], in_position[(i + 1) & 3]);
    out_toward_previous[gl_InvocationID] = edge_point(in_position[i], in_normal[i], in_position[(i + 3) & 3]);
    if (i == 0) {
        out_patch = in_patch[0];
        uvec4 edge = patches[in_patch[0]].edges >> 1;
        // A patch orders its edges as v=0, u=1, v=1, u=0. The tessellator's order is u=0, v=0, u=1, v=1.
        vec4 factor = vec4(edge_factors[edge.x], edge_factors[edge.y], edge_factors[edge.z], edge_factors[edge.w]);
        gl_TessLevelOuter[0] = factor.w;
        gl_TessLevelOuter[1] = factor.x;
        gl_TessLevelOuter[2] = factor.y;
        gl_TessLevelOuter[3] = factor.z;
        gl_TessLevelInner[0] = max(factor.x, factor.z);
        gl_TessLevelInner[1] = max(factor.y, factor.w);
    }
}
