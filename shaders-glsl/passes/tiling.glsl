// Repeating maps, tiled by example so that no repeats are visible (leadr/slopes/tiling.glsl).
#ifndef LEADR_TILING
#define LEADR_TILING
#include "constants.glsl"
#include "leadr/slopes/tiling.glsl"

// The variants at a point and their offsets in repeats. All taps of a pixel share the variants, because a footprint longer than a lattice
// cell covers as much of the map in one variant as in several.
struct OffsetVariants {
    TilingVariants of;
    vec2 from_a;
    vec2 from_b;
    vec2 from_c;
    bool single; // there is a single variant, which is the map unchanged
};

const TilingVariant NO_VARIANT = TilingVariant(ivec2(0), 0.0, vec2(0.0));
const TilingVariant FULL_VARIANT = TilingVariant(ivec2(0), 1.0, vec2(0.0));
const OffsetVariants NO_VARIANTS =
    OffsetVariants(TilingVariants(NO_VARIANT, NO_VARIANT, NO_VARIANT), vec2(0.0), vec2(0.0), vec2(0.0), false);
const OffsetVariants ONE_VARIANT =
    OffsetVariants(TilingVariants(FULL_VARIANT, NO_VARIANT, NO_VARIANT), vec2(0.0), vec2(0.0), vec2(0.0), true);

// Returns the variants at a point. flags are the flags of the object.
OffsetVariants offset_variants(const vec2 at, const uint flags) {
    if ((flags & FLAG_ONE_VARIANT) != 0u) {
        return ONE_VARIANT;
    }
    TilingVariants variants = tiling_variants(at, TILING_CELLS);
    return OffsetVariants(variants, variant_offset(variants.a.corner), variant_offset(variants.b.corner),
                          variant_offset(variants.c.corner), false);
}

OffsetVariants merged_at(OffsetVariants variants, const float lod) {
    variants.of = merged_variants(variants.of, lod);
    return variants;
}

// Returns the number of variants with weight. Loops end there, because drivers without divergent branches (lavapipe) run both sides of an
// `if`.
int tiling_count(const OffsetVariants variants) {
    return variants.of.c.weight > 0.0 ? 3 : (variants.of.b.weight > 0.0 ? 2 : 1);
}

// Moves the next variant to the front.
void next_variant(inout OffsetVariants variants) {
    variants.of.a = variants.of.b;
    variants.of.b = variants.of.c;
    variants.from_a = variants.from_b;
    variants.from_b = variants.from_c;
}

// One loop covers all variants of all taps, because nested loops cost more than their bodies on such drivers.
struct TapVariant {
    int tap;
    int variant;
    vec2 from;
    float weight;
    bool last; // whether it is the last variant of its tap
};

TapVariant variant_of_tap(const OffsetVariants variants, const int tap, const int variant) {
    vec2 from = variant == 0 ? variants.from_a : (variant == 1 ? variants.from_b : variants.from_c);
    float weight = variant == 0 ? variants.of.a.weight : (variant == 1 ? variants.of.b.weight : variants.of.c.weight);
    return TapVariant(tap, variant, from, weight, variant + 1 == tiling_count(variants));
}

TapVariant first_variant(const OffsetVariants variants) {
    return variant_of_tap(variants, 0, 0);
}

void next_variant(inout TapVariant now, const OffsetVariants variants) {
    now = variant_of_tap(variants, now.last ? now.tap + 1 : now.tap, now.last ? 0 : now.variant + 1);
}

// Returns the fraction of a map's deviation from its mean that remains at this level of detail.
float tiling_part(const OffsetVariants variants, sampler2D map, const float lod) {
    return variants.single ? 1.0 : tiling_fade(lod, float(textureSize(map, 0).x), TILING_CELLS);
}

// Returns the mean of a map, which is its last mip level.
vec4 map_mean(sampler2D map) {
    return textureLod(map, vec2(0.5), float(textureQueryLevels(map) - 1));
}

// Returns the height of a map tiled by example. passing returns the slope, by texture coordinate, that the height difference between
// blended variants adds.
float tiled_height(sampler2D heights, OffsetVariants variants, const vec2 at, const float lod, out vec2 passing) {
    float mean = map_mean(heights).x, part = tiling_part(variants, heights, lod);
    passing = vec2(0.0);
    precise float height = mean;
    int count = tiling_count(variants);
    for (int i = 0; i < count; ++i) {
        float above = textureLod(heights, at + variants.from_a, lod).x - mean;
        height += variants.of.a.weight * part * above;
        passing += variants.of.a.slope * above;
        next_variant(variants);
    }
    return height;
}

float tiled_height(sampler2D heights, uint flags, vec2 at, float lod) {
    vec2 passing;
    return tiled_height(heights, offset_variants(at, flags), at, lod, passing);
}

#endif
