#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out flat uint out_patch;

// Each visible patch has four control points, which are read from storage buffers. There is no vertex or index buffer.
void main() {
    uint patch_index = visible_patches[gl_VertexIndex >> 2];
    Vertex vertex = vertices[patches[patch_index].vertices[gl_VertexIndex & 3]];
    out_position = vertex.position.xyz;
    out_normal = vertex.normal.xyz;
    out_patch = patch_index;
}
