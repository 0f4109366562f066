// How far a place on a surface moves from one pixel to the next, as the geometry pass hands it to the filter pass.
#ifndef LEADR_GEOMETRY_PLACE
#define LEADR_GEOMETRY_PLACE

// Halves begin to lose digits below 6e-5, which is a plausible part of a patch.
const float FOOTPRINT_SCALE = 1024.0;

// Derivatives of a place by x and y of the image.
uvec2 pack_footprint(const vec2 dx, const vec2 dy) {
    return uvec2(packHalf2x16(clamp(dx * FOOTPRINT_SCALE, -6e4, 6e4)), packHalf2x16(clamp(dy * FOOTPRINT_SCALE, -6e4, 6e4)));
}

mat2 unpack_footprint(const uvec2 packed) {
    return mat2(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y)) / FOOTPRINT_SCALE;
}

#endif
