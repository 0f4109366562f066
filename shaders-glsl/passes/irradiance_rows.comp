// First half of the SH projection: each invocation projects one row of one face in registers and writes nine
// partial sums. Shared-memory trees cost ten times as much on a CPU device (barriers), and no less on a GPU this small.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform sampler2DArray cube; // one mip level
layout(set = 0, binding = 1, std430) writeonly buffer Partials { vec4 partials[]; }; // [coefficient][face, row]

// LEADR Algorithm 2: the basis, in the order (0,0) (1,-1) (1,0) (1,1) (2,-2) … (2,2).
void basis(vec3 w, out float y[9])
{
    y[0] = 0.282094792;
    y[1] = 0.488602512 * w.y;
    y[2] = 0.488602512 * w.z;
    y[3] = 0.488602512 * w.x;
    y[4] = 1.092548431 * w.x * w.y;
    y[5] = 1.092548431 * w.y * w.z;
    y[6] = 0.315391565 * (3.0 * w.z * w.z - 1.0);
    y[7] = 1.092548431 * w.x * w.z;
    y[8] = 0.546274215 * (w.x * w.x - w.y * w.y);
}

void main()
{
    int size = textureSize(cube, 0).x;
    uint rows = 6u * uint(size);
    uint row = gl_GlobalInvocationID.x;
    if (row >= rows) return;
    int face = int(row) / size;
    int j = int(row) % size;
    float d = 2.0 / float(size);
    vec3 sum[9];
    for (int k = 0; k < 9; ++k) sum[k] = vec3(0.0);
    for (int i = 0; i < size; ++i) {
        vec2 st = (vec2(i, j) + 0.5) * d - 1.0;
        vec3 radiance = cube_solid_angle(st, d) * texelFetch(cube, ivec3(i, j, face), 0).rgb;
        float y[9];
        basis(normalize(cube_direction(face, st)), y);
        for (int k = 0; k < 9; ++k) sum[k] += y[k] * radiance;
    }
    for (int k = 0; k < 9; ++k) partials[uint(k) * rows + row] = vec4(sum[k], 0.0);
}
