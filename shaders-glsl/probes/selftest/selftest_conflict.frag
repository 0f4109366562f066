#version 460
// Declares a texture with the name of a buffer in selftest.vert.
uniform sampler2D Corners;
layout(location = 0) out vec4 target;

void main() {
    target = texelFetch(Corners, ivec2(0), 0);
}
