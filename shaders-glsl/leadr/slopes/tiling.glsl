#ifndef LEADR_SLOPE_TILING_GLSL
#define LEADR_SLOPE_TILING_GLSL

#include "moments.glsl"

// Tiling by example (Heitz and Neyret 2018): a map that repeats becomes one that does not, with the same mean and covariance. Corners of
// a lattice of triangles look at the map in different places; looks are blended about its mean by weights whose squares sum to one.
// crates/leadr-reflectance/src/slopes/tiling.rs explains it.

// The barycentric coordinate from which on the look of a corner is seen.
const float LEADR_LEAST_LOOK = 0.3;

// A look that a place sees.
struct TilingLook {
    ivec2 corner; // of the lattice
    float weight; // the squares of all sum to one
    vec2 slope;   // how the weight changes by texture coordinate
};

// Those of a place, in descending order of their weights.
struct TilingLooks {
    TilingLook a;
    TilingLook b;
    TilingLook c;
};

TilingLook tiling_look(const ivec2 corner, const float share, const vec2 slope) {
    float seen = max(share - LEADR_LEAST_LOOK, 0.0);
    return TilingLook(corner, seen * seen, slope * (2.0 * seen));
}

TilingLook normalised_look(const TilingLook look, const float per_length, const vec2 along) {
    float weight = look.weight * per_length;
    return TilingLook(look.corner, weight, (look.slope - along * weight) * per_length);
}

// cells: edges of the lattice along one repeat of the map.
TilingLooks tiling_looks(const vec2 texcoord, const float cells) {
    // Coordinates in which the triangles are halves of unit squares.
    vec2 at = vec2(texcoord.x - 0.57735026919 * texcoord.y, 1.15470053838 * texcoord.y) * cells;
    vec2 low = floor(at), inside = at - low;
    bool upper = inside.x + inside.y >= 1.0;
    vec2 local = upper ? 1.0 - inside : inside;
    float side = upper ? -1.0 : 1.0;
    ivec2 corner = ivec2(low) + (upper ? ivec2(1, 1) : ivec2(0, 0));
    int beside = upper ? -1 : 1;
    // By texture coordinate.
    vec2 by_x = vec2(side, -0.57735026919 * side) * cells, by_y = vec2(0.0, 1.15470053838 * side) * cells;
    TilingLook a = tiling_look(corner, 1.0 - local.x - local.y, -by_x - by_y);
    TilingLook b = tiling_look(corner + ivec2(beside, 0), local.x, by_x);
    TilingLook c = tiling_look(corner + ivec2(0, beside), local.y, by_y);
    float per_length = inversesqrt(a.weight * a.weight + b.weight * b.weight + c.weight * c.weight);
    vec2 along = (a.slope * a.weight + b.slope * b.weight + c.slope * c.weight) * per_length;
    a = normalised_look(a, per_length, along);
    b = normalised_look(b, per_length, along);
    c = normalised_look(c, per_length, along);
    if (b.weight > a.weight) {
        TilingLook swap = a;
        a = b;
        b = swap;
    }
    if (c.weight > a.weight) {
        TilingLook swap = a;
        a = c;
        c = swap;
    }
    if (c.weight > b.weight) {
        TilingLook swap = b;
        b = c;
        c = swap;
    }
    return TilingLooks(a, b, c);
}

// By how much of a repeat a corner's look at the map is moved: the hash pcg2d of Jarzynski and Olano 2020, in steps of 1/4096.
vec2 look_offset(const ivec2 corner) {
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

// Part of what differs from the mean that is left of looks as coarse as `lod` texels, as a power of two, of a map of `size` texels along a
// repeat: footprints as wide as the lattice average over looks.
float tiling_fade(const float lod, const float size, const float cells) {
    float t = clamp(log2(max(size / cells, 1.0)) + 1.0 - lod, 0.0, 2.0) * 0.5;
    return t * t * (3.0 - 2.0 * t);
}

// Where a texel of `lod` is so coarse that no eye tells a seam from the texels, the foremost look takes the place of the others.
TilingLooks merged_looks(TilingLooks looks, const float lod) {
    float left = 1.0 - clamp((lod - 3.0) / 1.5, 0.0, 1.0);
    looks.b.weight *= left;
    looks.c.weight *= left;
    looks.a.weight = sqrt(max(1.0 - looks.b.weight * looks.b.weight - looks.c.weight * looks.c.weight, 0.0));
    looks.a.slope *= left;
    looks.b.slope *= left;
    looks.c.slope *= left;
    return looks;
}

// Adds a look of such moments to a blend: first its mean slope, second its covariance. part: tiling_fade; what it takes from the mean
// slopes is in the covariance.
SlopeMoments add_look(const SlopeMoments blend, const SlopeMoments look, const float weight, const float part) {
    vec2 mean = look.first * part;
    vec3 covariance = look.second - vec3(mean * mean, mean.x * mean.y);
    return SlopeMoments(blend.first + mean * weight, blend.second + covariance * (weight * weight));
}

#endif
