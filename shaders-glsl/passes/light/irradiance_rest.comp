// Writes the irradiance of orders above 2 to a small cube map. The irradiance is the exact sum over a coarse level of the environment. Each
// invocation computes one normal.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
#include "leadr/integrals/sh.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2DArray environment; // one mip level
layout(rgba32f) uniform writeonly image2DArray rest;

void main()
{
    int size = imageSize(rest).x;
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (texel.x >= size || texel.y >= size) return;
    vec3 n = normalize(cube_direction(texel.z, (vec2(texel.xy) + 0.5) * (2.0 / float(size)) - 1.0));
    int across = textureSize(environment, 0).x;
    float d = 2.0 / float(across);
    vec3 sum = vec3(0.0);
    for (int j = 0; j < across; ++j)
        for (int i = 0; i < across; ++i) {
            // The coordinates are identical for all faces.
            vec2 st = (vec2(i, j) + 0.5) * d - 1.0;
            float weight = cube_solid_angle(st, d);
            float shortening = inversesqrt(1.0 + dot(st, st));
            for (int face = 0; face < 6; ++face) {
                float cosine = dot(n, cube_direction(face, st)) * shortening;
                sum += weight * sh_irradiance_rest(cosine) * texelFetch(environment, ivec3(i, j, face), 0).rgb;
            }
        }
    imageStore(rest, texel, vec4(sum, 1.0));
}
