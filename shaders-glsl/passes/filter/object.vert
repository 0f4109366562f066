#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the pixels of an object.
#include "../geometry/object.glsl"
#include "../object_depth.glsl"

void main() {
    gl_Position = object_corner(gl_VertexIndex, OBJECT.number);
}
