// Computes one mip level of the LEADR maps from the next finer level, by a box filter with exact area weights. Along an axis of odd size n
// = 2m + 1, each texel covers 2 + 1/m finer texels, so it needs three taps with the weights (m − i, m, i + 1) / n.
// crates/leadr-maps/src/moments.rs computes the same bits in the same order. The including file defines the formats SLOPES_FORMAT and
// JOINT_FORMAT (storage images need literal formats).
#include "moments_store.glsl"
// Groups are rows, as in moments.glsl.
layout(local_size_x = 64, local_size_y = 1) in;

layout(constant_id = 0) const bool EVEN = false; // whether width and height of the finer level are even

layout(SLOPES_FORMAT) uniform readonly image2D fine_slopes;
layout(JOINT_FORMAT) uniform readonly image2D fine_joint;
layout(r32f) uniform readonly image2D fine_height;
layout(SLOPES_FORMAT) uniform writeonly image2D slopes;
layout(JOINT_FORMAT) uniform writeonly image2D joint;
layout(r32f) uniform writeonly image2D mean_height;
layout(push_constant) uniform Push {
    float share[2]; // 1 / texels of the finer level, across and down
};

vec3 taps(const int i, const int n, const float share)
{
    if (n == 1) return vec3(1.0, 0.0, 0.0);
    if ((n & 1) == 0) return vec3(0.5, 0.5, 0.0);
    int m = n / 2;
    return vec3(m - i, m, i + 1) * share;
}

int tap_count(const int n) { return n == 1 ? 1 : 2 + (n & 1); }

void main()
{
    ivec2 size = imageSize(slopes);
    ivec2 fine = imageSize(fine_slopes);
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= size.x || p.y >= size.y) return;
    precise vec4 a = vec4(0.0);
    precise vec2 b = vec2(0.0);
    if (EVEN) {
        for (int i = 0; i < 4; ++i) {
            ivec2 q = 2 * p + ivec2(i & 1, i >> 1);
            a += 0.25 * imageLoad(fine_slopes, q);
            b += 0.25 * vec2(imageLoad(fine_joint, q).r, imageLoad(fine_height, q).r);
        }
    } else {
        vec3 wx = taps(p.x, fine.x, share[0]);
        vec3 wy = taps(p.y, fine.y, share[1]);
        for (int j = 0; j < tap_count(fine.y); ++j)
            for (int i = 0; i < tap_count(fine.x); ++i) {
                ivec2 q = 2 * p + ivec2(i, j);
                float weight = wx[i] * wy[j];
                a += weight * imageLoad(fine_slopes, q);
                b += weight * vec2(imageLoad(fine_joint, q).r, imageLoad(fine_height, q).r);
            }
    }
    vec4 moments = a;
    float mixed = b.x;
    as_stored(moments, mixed);
    imageStore(slopes, p, moments);
    imageStore(joint, p, vec4(mixed));
    imageStore(mean_height, p, vec4(b.y));
}
