#version 460
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"

layout(location = 0) out vec3 out_rest; // rest position, and vertex spacing
layout(location = 1) out flat uint out_patch;

void main() {
    uint patch_index = visible_patches[gl_VertexIndex >> 2];
    Vertex vertex = vertices[patches[patch_index][gl_VertexIndex & 3]];
    out_rest = vec3(vertex.position, vertex.spacing);
    out_patch = patch_index;
}
