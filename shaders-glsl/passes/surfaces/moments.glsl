// Heights -> level 0 of the LEADR maps (LEADR 3.2): first and second moments of the slopes per unit texture
// coordinate (the whole image is [0, 1]²), of the triangles between the texels' centres over the texel.
// The including file defines the formats SLOPES_FORMAT and SINGLE_FORMAT (storage images need them in the text).
#include "../constants.glsl"
#include "leadr/slopes/moments.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const uint EDGES = MOMENTS_REPEAT; // what lies beyond the edges: one of the MOMENTS_ constants

uniform sampler2D heights;
layout(SLOPES_FORMAT) uniform writeonly image2D slopes; // E[hs], E[ht], E[hs²], E[ht²]
layout(SINGLE_FORMAT) uniform writeonly image2D joint;  // E[hs·ht]
layout(SINGLE_FORMAT) uniform writeonly image2D mean_height;
layout(push_constant) uniform Push {
    uint tile;    // texels, a power of two; atlas only
    float limit;  // largest magnitude that the format holds
};

float height_at(ivec2 p) { return texelFetch(heights, p, 0).r; }

// The neighbours of texel i of n along one axis, and whether the surface continues to them.
ivec2 neighbours(int i, int n, out bvec2 inside)
{
    inside = bvec2(true);
    if (EDGES == MOMENTS_REPEAT) return ivec2(i == 0 ? n - 1 : i - 1, i == n - 1 ? 0 : i + 1);
    if (EDGES == MOMENTS_CLAMP) return ivec2(max(i - 1, 0), min(i + 1, n - 1));
    int first = i & ~int(tile - 1u), last = first + int(tile) - 1;
    inside = bvec2(i > first, i < last);
    return ivec2(max(i - 1, first), min(i + 1, last));
}

void main()
{
    ivec2 size = imageSize(slopes);
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= size.x || p.y >= size.y) return;
    bvec2 inside_s, inside_t;
    ivec2 s = neighbours(p.x, size.x, inside_s);
    ivec2 t = neighbours(p.y, size.y, inside_t);
    vec2 first = vec2(0.0);
    vec3 second = vec3(0.0);
    float quarters = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 side = ivec2(k & 1, k >> 1);
        // Beyond the edge of a tile there is no cell.
        if (inside_s[side.x] && inside_t[side.y]) {
            ivec2 q = ivec2(s[side.x], t[side.y]);
            vec4 heights = vec4(height_at(p), height_at(ivec2(q.x, p.y)), height_at(ivec2(p.x, q.y)), height_at(q));
            SlopeMoments quarter = moments_of_corner(heights, vec2(2 * side - 1) / vec2(size));
            first += quarter.first;
            second += quarter.second;
            quarters += 1.0;
        }
    }
    float share = 1.0 / max(quarters, 1.0);
    imageStore(slopes, p, clamp(vec4(first, second.xy) * share, -limit, limit));
    imageStore(joint, p, vec4(clamp(second.z * share, -limit, limit)));
    imageStore(mean_height, p, vec4(clamp(height_at(p), -limit, limit)));
}
