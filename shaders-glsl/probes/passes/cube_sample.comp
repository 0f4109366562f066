// Samples a cube map. The input is a direction and a level of detail (x, y, z, lod), and the output is r, g, b.
#version 460
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
uniform samplerCube cube;
layout(push_constant) uniform P { uint count; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    vec3 c = textureLod(cube, vec3(x[4 * i], x[4 * i + 1], x[4 * i + 2]), x[4 * i + 3]).rgb;
    y[3 * i] = c.r;
    y[3 * i + 1] = c.g;
    y[3 * i + 2] = c.b;
}
