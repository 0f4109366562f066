// Converts heights to level 0 of the LEADR maps (LEADR 4.1): the first and second moments of the slopes, per unit of texture coordinate
// (the whole image is [0, 1]²). The moments are means over a texel of the triangles between the texels' centres.
// crates/leadr-maps/src/moments.rs computes the same bits in the same order. The including file defines the formats SLOPES_FORMAT and
// JOINT_FORMAT (storage images need literal formats).
#include "../constants.glsl"
#define LEADR_PRECISE precise
#include "leadr/slopes/moments.glsl"
#include "moments_store.glsl"
// Groups are rows, so that no two threads write to one cache line.
layout(local_size_x = 64, local_size_y = 1) in;

layout(constant_id = 0) const uint EDGES = MOMENTS_REPEAT; // neighbours of the edge texels: a MOMENTS_ constant

layout(r32f) uniform readonly image2D heights;
layout(SLOPES_FORMAT) uniform writeonly image2D slopes; // E[hs], E[ht], E[hs²], E[ht²]
layout(JOINT_FORMAT) uniform writeonly image2D joint;   // E[hs·ht]
layout(push_constant) uniform Push {
    uint tile;    // size of a tile in texels, a power of two; atlases only
    float limit;  // largest magnitude in the format
};

float height_at(const ivec2 p) { return imageLoad(heights, p).r; }

// Returns the neighbours of texel i of n along one axis, and whether the surface continues to these neighbours.
ivec2 neighbours(const int i, const int n, out bvec2 inside)
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
    float here = height_at(p);
    vec2 across = vec2(height_at(ivec2(s.x, p.y)), height_at(ivec2(s.y, p.y)));
    vec2 along = vec2(height_at(ivec2(p.x, t.x)), height_at(ivec2(p.x, t.y)));
    vec4 corners = vec4(height_at(ivec2(s.x, t.x)), height_at(ivec2(s.y, t.x)), height_at(ivec2(s.x, t.y)), height_at(ivec2(s.y, t.y)));
    // There is no cell beyond the edge of a tile.
    vec2 ws = vec2(inside_s), wt = vec2(inside_t);
    vec4 weights = vec4(ws * wt.x, ws * wt.y);
    // Lengths are in texels here and below, so divisors are exact.
    SlopeMoments a = moments_of_corner(vec4(here, across.x, along.x, corners.x), vec2(-1.0, -1.0));
    SlopeMoments b = moments_of_corner(vec4(here, across.y, along.x, corners.y), vec2(1.0, -1.0));
    SlopeMoments c = moments_of_corner(vec4(here, across.x, along.y, corners.z), vec2(-1.0, 1.0));
    SlopeMoments d = moments_of_corner(vec4(here, across.y, along.y, corners.w), vec2(1.0));
    precise vec2 first = weights.x * a.first + weights.y * b.first + weights.z * c.first + weights.w * d.first;
    precise vec3 second = weights.x * a.second + weights.y * b.second + weights.z * c.second + weights.w * d.second;
    float quarters = weights.x + weights.y + weights.z + weights.w;
    float share = 1.0 / max(quarters, 1.0); // number of quarters: 1, 2 or 4
    vec2 texels = vec2(size);
    precise vec2 mean = first * share * texels;
    precise vec3 square = second * share * vec3(texels * texels, texels.x * texels.y);
    vec4 moments = clamp(vec4(mean, square.xy), -limit, limit);
    float mixed = clamp(square.z, -limit, limit);
    as_stored(moments, mixed);
    imageStore(slopes, p, moments);
    imageStore(joint, p, vec4(mixed));
}
