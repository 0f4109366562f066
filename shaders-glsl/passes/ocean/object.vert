#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the pixels of the sea.
#include "../constants.glsl"
#include "../object_depth.glsl"

void main() {
    gl_Position = object_corner(gl_VertexIndex, SEA_INDEX);
}
