// Computes one mip level of a cube map from the next finer level. A texel is the mean of 2×2 texels weighted by solid angle, which
// preserves the mean radiance over the sphere.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool SMALL = false; // whether texels of the finer level are narrower than a tenth of a unit

layout(rgba32f) uniform readonly image2DArray fine;
layout(rgba32f) uniform writeonly image2DArray coarse;

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    int size = imageSize(coarse).x;
    if (texel.x >= size || texel.y >= size) return;
    float d = 1.0 / float(size);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 p = 2 * texel.xy + ivec2(k & 1, k >> 1);
        vec2 st = (vec2(p) + 0.5) * d - 1.0;
        float weight = SMALL ? cube_solid_angle_small(st, d) : cube_solid_angle(st, d);
        sum += weight * imageLoad(fine, ivec3(p, texel.z));
        weights += weight;
    }
    imageStore(coarse, texel, sum / weights);
}
