#version 460
// Reads the corners in clip space from a storage buffer.
layout(std430) readonly buffer Corners { vec2 corners[]; };
layout(push_constant) uniform P { vec4 color; float depth; };

void main() {
    gl_Position = vec4(corners[gl_VertexIndex], depth, 1.0);
}
