#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the pixels that show no object.
#include "../object_depth.glsl"

void main() {
    gl_Position = object_corner(gl_VertexIndex, 0u);
}
