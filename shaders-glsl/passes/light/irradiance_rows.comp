// First half of the SH projection. Each invocation projects one row of one face in registers and writes nine partial sums. A reduction in
// shared memory needs barriers. Such a reduction costs ten times as much on a CPU device, and is no faster on a GPU for so little work.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
#include "leadr/integrals/sh.glsl"
layout(local_size_x = 64) in;

uniform sampler2DArray cube; // one mip level
layout(std430) writeonly buffer Partials { vec4 partials[]; }; // [coefficient][face, row]

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
        float basis[9] = sh_basis(normalize(cube_direction(face, st)));
        for (int k = 0; k < 9; ++k) sum[k] += basis[k] * radiance;
    }
    for (int k = 0; k < 9; ++k) partials[uint(k) * rows + row] = vec4(sum[k], 0.0);
}
