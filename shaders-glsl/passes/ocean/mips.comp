#version 460
// Computes the next coarser level of the three maps of every cascade, as means of 2 x 2 texels.
layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f) uniform readonly image2DArray fine_displacement;
layout(rgba32f) uniform readonly image2DArray fine_slopes;
layout(rgba32f) uniform readonly image2DArray fine_joint;
layout(rgba32f) uniform writeonly image2DArray displacement;
layout(rgba32f) uniform writeonly image2DArray slopes;
layout(rgba32f) uniform writeonly image2DArray joint;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    ivec3 size = imageSize(slopes);
    if (any(greaterThanEqual(texel, size))) {
        return;
    }
    vec4 d = vec4(0.0), s = vec4(0.0), j = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec3 at = ivec3(2 * texel.xy + ivec2(i & 1, i >> 1), texel.z);
        d += imageLoad(fine_displacement, at);
        s += imageLoad(fine_slopes, at);
        j += imageLoad(fine_joint, at);
    }
    imageStore(displacement, texel, 0.25 * d);
    imageStore(slopes, texel, 0.25 * s);
    imageStore(joint, texel, 0.25 * j);
}
