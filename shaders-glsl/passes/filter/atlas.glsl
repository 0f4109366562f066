// An atlas with one tile per patch, filtered as one surface. Filter taps cross the borders between patches. Coarser levels follow the
// coarsest mip of the tiles, and neighbouring patches share the samples of these levels (crates/leadr-render/src/surfaces/atlas).
#ifndef LEADR_FILTER_ATLAS
#define LEADR_FILTER_ATLAS

#include "../constants.glsl"
#include "../geometry/detail_height.glsl"
#include "leadr/slopes/statistics.glsl"

struct PatchLink {
    uvec4 neighbors; // patches beyond the sides v=0, u=1, v=1, u=0, as patch << 2 | side
    uvec4 turns;     // x: quarter turns to the directions that are aligned with those of the neighbours
    vec4 gradient_transforms[8];   // two per side, at the corners: each rotates the neighbour's gradients into this patch
};

layout(set = 2, std430) readonly buffer Atlas {
    uint tile_size;      // size of a tile in texels
    uint tile_gutter;
    uint tile_columns;
    uint finest_coarse;  // binary logarithm of the number of intervals along a patch in the first coarse level
    PatchLink links[];
};
layout(set = 2) uniform sampler2D coarse_color;
layout(set = 2) uniform sampler2D coarse_f0;
layout(set = 2) uniform sampler2D coarse_light; // rgb emission, a accessibility

// The position of a filter tap.
struct AtlasPoint {
    uint index;    // number of the patch
    vec2 at;       // position on the patch, [0, 1]^2
    mat2 gradient; // transforms gradients at this position to gradients on the pixel's own patch
};

float tile_inner() {
    return float(tile_size - 2u * tile_gutter);
}

// Returns the first texel of a patch in the atlas, after the gutter.
vec2 tile_start(const uint index) {
    return vec2(uvec2(index % tile_columns, index / tile_columns) * tile_size + tile_gutter);
}

vec2 patch_uv_at(const uint index, const vec2 texel) {
    return (texel - tile_start(index)) / tile_inner();
}

// Finds the patch that contains a position `at` outside the patch `index`, across at most two borders.
AtlasPoint point_across_borders(uint index, vec2 at) {
    AtlasPoint point = AtlasPoint(index, at, mat2(1.0));
    for (int border = 0; border < 2; ++border) {
        vec2 beyond = max(-point.at, point.at - 1.0);
        float over = max(beyond.x, beyond.y);
        if (over <= 0.0) {
            break;
        }
        uint side = beyond.x > beyond.y ? (point.at.x < 0.0 ? 3u : 1u) : (point.at.y < 0.0 ? 0u : 2u);
        uint link = links[point.index].neighbors[side];
        if (link == NO_NEIGHBOR) {
            break;
        }
        float along = (side & 1u) == 0u ? point.at.x : point.at.y;
        along = side < 2u ? along : 1.0 - along;
        vec4 gradient_transform =
            mix(links[point.index].gradient_transforms[2u * side], links[point.index].gradient_transforms[2u * side + 1u],
                clamp(along, 0.0, 1.0));
        point.gradient = point.gradient * mat2(gradient_transform.xy, gradient_transform.zw);
        point.index = link >> 2;
        // The neighbour traverses the shared edge in the other direction.
        uint beside = link & 3u;
        vec2 inward = vec2(1.0 - along, over);
        inward = beside < 2u ? inward : vec2(along, 1.0 - over);
        point.at = beside == 1u || beside == 3u ? vec2(1.0 - inward.y, inward.x) : inward;
    }
    point.at = clamp(point.at, 0.0, 1.0);
    return point;
}

// Returns the matrix that converts slopes along the sides of a patch to slopes along its aligned directions.
mat2 aligned_slopes(const uint index) {
    uint turn = links[index].turns.x;
    vec2 s = (turn & 1u) == 0u ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    s = turn < 2u ? s : -s;
    return transpose(mat2(s, vec2(-s.y, s.x)));
}

// Returns the rotation that is nearest to the conversion of gradients between two patches.
mat2 nearest_rotation(const mat2 gradient) {
    vec2 turn = vec2(gradient[0][0] + gradient[1][1], gradient[0][1] - gradient[1][0]);
    turn *= inversesqrt(max(dot(turn, turn), 1e-30));
    return mat2(turn.x, turn.y, -turn.y, turn.x);
}

// Describes how a level of detail blends the mips of a tile with two coarse levels, and where the two levels lie in the coarse images.
struct Levels {
    float mip;
    float fine; // weight of the tile's mips
    float second; // weight of the second coarse level relative to the sum of both
    uint first;
};

Levels levels_at(const float lod) {
    float first_lod = log2(tile_inner()) - float(finest_coarse);
    float level = clamp(lod - first_lod, 0.0, float(finest_coarse + WIDE_LEVELS));
    Levels levels;
    levels.mip = min(lod, float(SOURCE_LEVEL));
    levels.fine = clamp((first_lod - lod) / max(first_lod - float(SOURCE_LEVEL), 1e-3), 0.0, 1.0);
    levels.first = min(uint(level), finest_coarse + WIDE_LEVELS - 1u);
    levels.second = level - float(levels.first);
    return levels;
}

// Returns a position in a coarse level, in texels of the coarse image.
vec2 coarse_texel(const AtlasPoint point, const uint level) {
    uint intervals = 1u << (finest_coarse - min(level, finest_coarse));
    // The rows of the preceding levels are 2^k + 1 rows each, then two.
    uint row = (2u << finest_coarse) - 2u * intervals + level + (level > finest_coarse ? level - finest_coarse : 0u);
    uvec2 block = uvec2((1u << finest_coarse) + 1u, (2u << finest_coarse) + finest_coarse + 2u * WIDE_LEVELS);
    uvec2 start = uvec2(point.index % tile_columns, point.index / tile_columns) * block + uvec2(0u, row);
    return vec2(start) + point.at * float(intervals) + 0.5;
}

// Returns the contribution of the tile's mips to a blend. coarse_part returns the contribution of the coarse levels.
vec4 fine_part(sampler2D fine, const AtlasPoint point, const Levels levels) {
    if (levels.fine <= 0.0) {
        return vec4(0.0);
    }
    vec2 texel = tile_start(point.index) + point.at * tile_inner();
    return textureLod(fine, texel / vec2(textureSize(fine, 0)), levels.mip) * levels.fine;
}

vec4 coarse_part(sampler2D coarse, const AtlasPoint point, const Levels levels) {
    if (levels.fine >= 1.0) {
        return vec4(0.0);
    }
    vec2 size = vec2(textureSize(coarse, 0));
    vec4 first = textureLod(coarse, coarse_texel(point, levels.first) / size, 0.0);
    vec4 second = textureLod(coarse, coarse_texel(point, levels.first + 1u) / size, 0.0);
    return mix(first, second, levels.second) * (1.0 - levels.fine);
}

// Returns a layer of the mix. The tile's mip is read at the texture coordinate `fine_at`, at the level `mip`.
vec4 layer_mix(sampler2DArray fine, sampler2DArray coarse, const int layer, const vec2 fine_at, const float mip, const AtlasPoint point,
               const Levels levels) {
    vec4 mixed = vec4(0.0);
    if (levels.fine > 0.0) {
        mixed = textureLod(fine, vec3(fine_at, float(layer)), mip) * levels.fine;
    }
    if (levels.fine < 1.0) {
        vec2 size = vec2(textureSize(coarse, 0).xy);
        vec4 first = textureLod(coarse, vec3(coarse_texel(point, levels.first) / size, float(layer)), 0.0);
        vec4 second = textureLod(coarse, vec3(coarse_texel(point, levels.first + 1u) / size, float(layer)), 0.0);
        mixed += mix(first, second, levels.second) * (1.0 - levels.fine);
    }
    return mixed;
}

vec4 level_mix(sampler2D fine, sampler2D coarse, const AtlasPoint point, const Levels levels) {
    return fine_part(fine, point, levels) + coarse_part(coarse, point, levels);
}

#endif
