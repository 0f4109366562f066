// Change of a surface position from one pixel to the next, packed between geometry and filter pass.
#ifndef LEADR_GEOMETRY_FOOTPRINT
#define LEADR_GEOMETRY_FOOTPRINT

// Halves lose precision below 6e-5, which is a plausible fraction of a patch.
const float FOOTPRINT_SCALE = 1024.0;

// Derivatives of a position by x and y of the image.
uvec2 pack_footprint(const vec2 dx, const vec2 dy) {
    return uvec2(packHalf2x16(clamp(dx * FOOTPRINT_SCALE, -6e4, 6e4)), packHalf2x16(clamp(dy * FOOTPRINT_SCALE, -6e4, 6e4)));
}

mat2 unpack_footprint(const uvec2 packed) {
    return mat2(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y)) / FOOTPRINT_SCALE;
}

#endif
