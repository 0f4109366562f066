// Maps that repeat, shown without their repeats (leadr/slopes/tiling.glsl).
#ifndef LEADR_TILING
#define LEADR_TILING
#include "constants.glsl"
#include "leadr/slopes/tiling.glsl"

// The looks of a place, and by how much of a repeat each of them is moved. A pixel has them once, for all its taps: a footprint that is longer
// than a cell of the lattice sees as much of the map in one look as in several.
struct PlacedLooks {
    TilingLooks of;
    vec2 from_a;
    vec2 from_b;
    vec2 from_c;
    bool whole; // one look everywhere: the map as it is
};

const TilingLook NO_LOOK = TilingLook(ivec2(0), 0.0, vec2(0.0));
const TilingLook WHOLE_LOOK = TilingLook(ivec2(0), 1.0, vec2(0.0));
const PlacedLooks NO_LOOKS = PlacedLooks(TilingLooks(NO_LOOK, NO_LOOK, NO_LOOK), vec2(0.0), vec2(0.0), vec2(0.0), false);
const PlacedLooks ONE_LOOK = PlacedLooks(TilingLooks(WHOLE_LOOK, NO_LOOK, NO_LOOK), vec2(0.0), vec2(0.0), vec2(0.0), true);

// flags: of the object.
PlacedLooks placed_looks(const vec2 at, const uint flags) {
    if ((flags & FLAG_ONE_LOOK) != 0u) {
        return ONE_LOOK;
    }
    TilingLooks looks = tiling_looks(at, TILING_CELLS);
    return PlacedLooks(looks, look_offset(looks.a.corner), look_offset(looks.b.corner), look_offset(looks.c.corner), false);
}

PlacedLooks merged_at(PlacedLooks looks, const float lod) {
    looks.of = merged_looks(looks.of, lod);
    return looks;
}

// The rest of a place's looks have no weight: loops end before them, since drivers without divergent branches (lavapipe) run both sides
// of an `if`.
int tiling_count(const PlacedLooks looks) {
    return looks.of.c.weight > 0.0 ? 3 : (looks.of.b.weight > 0.0 ? 2 : 1);
}

// The next look becomes the first.
void next_look(inout PlacedLooks looks) {
    looks.of.a = looks.of.b;
    looks.of.b = looks.of.c;
    looks.from_a = looks.from_b;
    looks.from_b = looks.from_c;
}

// All looks of all taps of a footprint are one loop: a loop inside another costs such drivers more than what it does.
struct TapLook {
    int tap;
    int look;
    vec2 from;
    float weight;
    bool last; // of its tap
};

TapLook look_of_tap(const PlacedLooks looks, const int tap, const int look) {
    vec2 from = look == 0 ? looks.from_a : (look == 1 ? looks.from_b : looks.from_c);
    float weight = look == 0 ? looks.of.a.weight : (look == 1 ? looks.of.b.weight : looks.of.c.weight);
    return TapLook(tap, look, from, weight, look + 1 == tiling_count(looks));
}

TapLook first_look(const PlacedLooks looks) {
    return look_of_tap(looks, 0, 0);
}

void next_look(inout TapLook now, const PlacedLooks looks) {
    now = look_of_tap(looks, now.last ? now.tap + 1 : now.tap, now.last ? 0 : now.look + 1);
}

// What is left of a map's difference from its mean at this level of detail.
float tiling_part(const PlacedLooks looks, sampler2D map, const float lod) {
    return looks.whole ? 1.0 : tiling_fade(lod, float(textureSize(map, 0).x), TILING_CELLS);
}

// The mean of a map, in its last level.
vec4 map_mean(sampler2D map) {
    return textureLod(map, vec2(0.5), float(textureQueryLevels(map) - 1));
}

// passing: the slope of the height, by texture coordinate, where one look passes into another: the higher one slopes down.
float tiled_height(sampler2D heights, PlacedLooks looks, const vec2 at, const float lod, out vec2 passing) {
    float mean = map_mean(heights).x, part = tiling_part(looks, heights, lod);
    passing = vec2(0.0);
    precise float height = mean;
    int count = tiling_count(looks);
    for (int i = 0; i < count; ++i) {
        float above = textureLod(heights, at + looks.from_a, lod).x - mean;
        height += looks.of.a.weight * part * above;
        passing += looks.of.a.slope * above;
        next_look(looks);
    }
    return height;
}

float tiled_height(sampler2D heights, uint flags, vec2 at, float lod) {
    vec2 passing;
    return tiled_height(heights, placed_looks(at, flags), at, lod, passing);
}

#endif
