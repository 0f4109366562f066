// Maps that repeat, shown without their repeats (leadr/slopes/tiling.glsl).
#ifndef LEADR_TILING
#define LEADR_TILING
#include "constants.glsl"
#include "leadr/slopes/tiling.glsl"

// The rest of a place's looks have no weight: loops end before them, since drivers without divergent branches (lavapipe) run both sides
// of an `if`.
int tiling_count(TilingLooks looks) {
    return looks.c.weight > 0.0 ? 3 : (looks.b.weight > 0.0 ? 2 : 1);
}

// The next look becomes the first.
void next_look(inout TilingLooks looks) {
    looks.a = looks.b;
    looks.b = looks.c;
}

// What is left of a map's difference from its mean at this level of detail.
float tiling_part(sampler2D map, float lod) {
    return tiling_fade(lod, float(textureSize(map, 0).x), TILING_CELLS);
}

// The mean of a map, in its last level.
vec4 map_mean(sampler2D map) {
    return textureLod(map, vec2(0.5), float(textureQueryLevels(map) - 1));
}

float tiled_height(sampler2D heights, vec2 at, float lod) {
    TilingLooks looks = tiling_looks(at, TILING_CELLS);
    float mean = map_mean(heights).x, part = tiling_part(heights, lod);
    precise float height = mean;
    int count = tiling_count(looks);
    for (int i = 0; i < count; ++i) {
        height += looks.a.weight * part * (textureLod(heights, at + look_offset(looks.a.corner), lod).x - mean);
        next_look(looks);
    }
    return height;
}

#endif
