// The change of a surface position from one pixel to the next, packed for the filter pass.
#ifndef LEADR_GEOMETRY_FOOTPRINT
#define LEADR_GEOMETRY_FOOTPRINT

// Values are scaled, because halves lose precision below 6e-5, and derivatives of this size occur.
const float FOOTPRINT_SCALE = 1024.0;

// Packs the derivatives of a position by x and y of the image.
uvec2 pack_footprint(const vec2 dx, const vec2 dy) {
    return uvec2(packHalf2x16(clamp(dx * FOOTPRINT_SCALE, -6e4, 6e4)), packHalf2x16(clamp(dy * FOOTPRINT_SCALE, -6e4, 6e4)));
}

mat2 unpack_footprint(const uvec2 packed) {
    return mat2(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y)) / FOOTPRINT_SCALE;
}

#endif
