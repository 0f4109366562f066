// Heights -> level 0 of the LEADR maps (LEADR 3.2): first and second moments of the slopes per unit texture
// coordinate (the whole image is [0, 1]²), by central differences.
// The including file defines the formats SLOPES_FORMAT and SINGLE_FORMAT (storage images need them in the text).
#include "../constants.glsl"
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

// The two neighbours along one axis; their distance in texels is what the difference is divided by.
ivec2 neighbours(int i, int n, out float distance)
{
    distance = 2.0;
    if (EDGES == MOMENTS_REPEAT) return ivec2(i == 0 ? n - 1 : i - 1, i == n - 1 ? 0 : i + 1);
    if (EDGES == MOMENTS_CLAMP) return ivec2(max(i - 1, 0), min(i + 1, n - 1));
    int first = i & ~int(tile - 1u);
    ivec2 pair = ivec2(max(i - 1, first), min(i + 1, first + int(tile) - 1));
    distance = float(pair.y - pair.x);
    return pair;
}

void main()
{
    ivec2 size = imageSize(slopes);
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= size.x || p.y >= size.y) return;
    float ds, dt;
    ivec2 s = neighbours(p.x, size.x, ds);
    ivec2 t = neighbours(p.y, size.y, dt);
    vec2 slope = vec2(height_at(ivec2(s.y, p.y)) - height_at(ivec2(s.x, p.y)),
                      height_at(ivec2(p.x, t.y)) - height_at(ivec2(p.x, t.x)))
               * vec2(size) / vec2(ds, dt);
    imageStore(slopes, p, clamp(vec4(slope, slope * slope), -limit, limit));
    imageStore(joint, p, vec4(clamp(slope.x * slope.y, -limit, limit)));
    imageStore(mean_height, p, vec4(clamp(height_at(p), -limit, limit)));
}
