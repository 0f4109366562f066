#version 460
// Samples a cube map. For each item, x holds a direction and a level of detail, and y receives the colour.
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { vec4 x[]; };
layout(std430) writeonly buffer Out { vec4 y[]; };
uniform samplerCube cube;
layout(push_constant) uniform P { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        y[i] = textureLod(cube, x[i].xyz, x[i].w);
    }
}
