#version 460
// Calls a texture what selftest.vert calls a buffer.
uniform sampler2D Corners;
layout(location = 0) out vec4 target;

void main() {
    target = texelFetch(Corners, ivec2(0), 0);
}
