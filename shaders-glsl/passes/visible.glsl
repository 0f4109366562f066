// The word that identifies a pixel's surface (VisibleSurface in crates/leadr-render/src/passes/targets/visible_surface.rs): the patch is in
// its low bits, and the object in its high bits. The number of objects in the scene determines the split (surfaces/numbering.rs). The third
// word after this word is the position in the image.
#ifndef LEADR_VISIBLE
#define LEADR_VISIBLE

layout(constant_id = 90) const uint OBJECT_BIT_COUNT = 6u;

const uint OBJECT_SHIFT = 30u - OBJECT_BIT_COUNT;
const uint PATCH_BITS = (1u << OBJECT_SHIFT) - 1u;
const uint OBJECT_BITS = 0x3fffffffu - PATCH_BITS; // numbered from 1; 0 means no object
const uint SEA_INDEX = (1u << OBJECT_BIT_COUNT) - 1u; // the last object number, which is the sea
const uint OF_THE_PIXEL = 0x40000000u;   // an edge sample on its pixel's own surface (edges.comp)
const uint INSIDE = 0x80000000u;         // a back face of a triangle or of a marked object
const uint BESIDE = 0x40000000u;         // a sample whose position at the pixel centre lies outside its patch (msaa.comp)
const uint NOBODY = 0xffffffffu;         // marks a texel that is not a pixel (msaa.comp)

// Two points of one object in a pixel belong to one surface under two conditions: they differ by less than a pixel along their normal, and
// the cosine between their displacement directions exceeds this value.
const float SAME_NORMAL = 0.9;

uint object_of(const uint word) {
    return (word & OBJECT_BITS) >> OBJECT_SHIFT;
}

// Packs a position in the image, in pixels, to a quarter of a pixel.
uint pack_position(const vec2 position) {
    uvec2 quarters = uvec2(round(4.0 * position));
    return quarters.x | quarters.y << 16;
}

vec2 position_of(const uint packed) {
    return 0.25 * vec2(packed & 0xffffu, packed >> 16);
}

#endif
