#ifndef LEADR_SLOPE_TILING_GLSL
#define LEADR_SLOPE_TILING_GLSL

#include "moments.glsl"

// Tiling by example (Heitz and Neyret 2018) replaces a repeating map by a map without repeats that has the same mean and covariance. Each
// corner of a triangle lattice samples the map at its own offset, which gives a variant of the map. The variants are blended about the
// map's mean, with weights whose squares sum to one. crates/leadr-reflectance/src/slopes/tiling.rs explains the method.

// The barycentric coordinate above which the variant of a corner is visible.
const float LEADR_VARIANT_THRESHOLD = 0.3;

// A variant of the map that is visible at a point.
struct TilingVariant {
    ivec2 corner; // corner of the lattice
    float weight; // the squares of all weights sum to one
    vec2 slope;   // derivative of the weight with respect to the texture coordinate
};

// The variants that are visible at a point, in descending order of their weights.
struct TilingVariants {
    TilingVariant a;
    TilingVariant b;
    TilingVariant c;
};

TilingVariant tiling_variant(const ivec2 corner, const float share, const vec2 slope) {
    float seen = max(share - LEADR_VARIANT_THRESHOLD, 0.0);
    return TilingVariant(corner, seen * seen, slope * (2.0 * seen));
}

TilingVariant normalised_variant(const TilingVariant variant, const float per_length, const vec2 along) {
    float weight = variant.weight * per_length;
    return TilingVariant(variant.corner, weight, (variant.slope - along * weight) * per_length);
}

// Returns the variants at a texture coordinate. cells is the number of lattice edges along one repeat of the map.
TilingVariants tiling_variants(const vec2 texcoord, const float cells) {
    // In these skewed coordinates, the triangles are halves of unit squares.
    vec2 at = vec2(texcoord.x - 0.57735026919 * texcoord.y, 1.15470053838 * texcoord.y) * cells;
    vec2 low = floor(at), inside = at - low;
    bool upper = inside.x + inside.y >= 1.0;
    vec2 local = upper ? 1.0 - inside : inside;
    float side = upper ? -1.0 : 1.0;
    ivec2 corner = ivec2(low) + (upper ? ivec2(1, 1) : ivec2(0, 0));
    int beside = upper ? -1 : 1;
    // The derivatives of the barycentric coordinates with respect to the texture coordinate.
    vec2 by_x = vec2(side, -0.57735026919 * side) * cells, by_y = vec2(0.0, 1.15470053838 * side) * cells;
    TilingVariant a = tiling_variant(corner, 1.0 - local.x - local.y, -by_x - by_y);
    TilingVariant b = tiling_variant(corner + ivec2(beside, 0), local.x, by_x);
    TilingVariant c = tiling_variant(corner + ivec2(0, beside), local.y, by_y);
    float per_length = inversesqrt(a.weight * a.weight + b.weight * b.weight + c.weight * c.weight);
    vec2 along = (a.slope * a.weight + b.slope * b.weight + c.slope * c.weight) * per_length;
    a = normalised_variant(a, per_length, along);
    b = normalised_variant(b, per_length, along);
    c = normalised_variant(c, per_length, along);
    if (b.weight > a.weight) {
        TilingVariant swap = a;
        a = b;
        b = swap;
    }
    if (c.weight > a.weight) {
        TilingVariant swap = a;
        a = c;
        c = swap;
    }
    if (c.weight > b.weight) {
        TilingVariant swap = b;
        b = c;
        c = swap;
    }
    return TilingVariants(a, b, c);
}

// Returns the offset of a corner's variant in the map, in repeats, in steps of 1/4096. The hash is pcg2d (Jarzynski and Olano 2020).
vec2 variant_offset(const ivec2 corner) {
    uint x = uint(corner.x) * 1664525u + 1013904223u, y = uint(corner.y) * 1664525u + 1013904223u;
    x += y * 1664525u;
    y += x * 1664525u;
    x ^= x >> 16u;
    y ^= y >> 16u;
    x += y * 1664525u;
    y += x * 1664525u;
    x ^= x >> 16u;
    y ^= y >> 16u;
    return vec2(float(x >> 20u), float(y >> 20u)) / 4096.0;
}

// Returns the fraction of the deviation from the mean that remains at level of detail `lod` (log2 of texels). `size` is the number of
// texels per repeat. A footprint as wide as the lattice averages over the variants.
float tiling_fade(const float lod, const float size, const float cells) {
    float t = clamp(log2(max(size / cells, 1.0)) + 1.0 - lod, 0.0, 2.0) * 0.5;
    return t * t * (3.0 - 2.0 * t);
}

// At coarse levels, where a seam is as small as a texel, the variant with the largest weight replaces all others.
TilingVariants merged_variants(TilingVariants variants, const float lod) {
    float left = 1.0 - clamp((lod - 3.0) / 1.5, 0.0, 1.0);
    variants.b.weight *= left;
    variants.c.weight *= left;
    variants.a.weight = sqrt(max(1.0 - variants.b.weight * variants.b.weight - variants.c.weight * variants.c.weight, 0.0));
    variants.a.slope *= left;
    variants.b.slope *= left;
    variants.c.slope *= left;
    return variants;
}

// Adds a variant's moments to a blend. `first` is the mean slope, and `second` is the covariance. `part` is the result of tiling_fade. The
// deviation that this fade removes from the mean slopes is added to the covariance.
SlopeMoments add_variant(const SlopeMoments blend, const SlopeMoments variant, const float weight, const float part) {
    vec2 mean = variant.first * part;
    vec3 covariance = variant.second - vec3(mean * mean, mean.x * mean.y);
    return SlopeMoments(blend.first + mean * weight, blend.second + covariance * (weight * weight));
}

#endif
