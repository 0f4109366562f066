// The word that identifies a pixel's surface (VisibleSurface in crates/leadr-render/src/passes/targets/visible_surface.rs): the
// patch in its low bits, the object above. The number of objects in the scene sets the split (surfaces/numbering.rs). The third
// word after it is the position in the image.
#ifndef LEADR_VISIBLE
#define LEADR_VISIBLE

layout(constant_id = 90) const uint OBJECT_BIT_COUNT = 6u;

const uint OBJECT_SHIFT = 30u - OBJECT_BIT_COUNT;
const uint PATCH_BITS = (1u << OBJECT_SHIFT) - 1u;
const uint OBJECT_BITS = 0x3fffffffu - PATCH_BITS; // from 1; 0 without an object
const uint SEA_INDEX = (1u << OBJECT_BIT_COUNT) - 1u; // the last object
const uint OF_THE_PIXEL = 0x40000000u;   // an edge sample on its pixel's own surface (edges.comp)
const uint INSIDE = 0x80000000u;         // a back face of triangles, or of marked objects
const uint BESIDE = 0x40000000u;         // a sample whose position at the pixel centre is off its patch (msaa.comp)
const uint NOBODY = 0xffffffffu;         // not a pixel (msaa.comp)

// Two points of one object in a pixel belong to one surface if they differ by less than a pixel along their normal, and the
// cosine between their displacement directions is above this.
const float SAME_NORMAL = 0.9;

uint object_of(const uint word) {
    return (word & OBJECT_BITS) >> OBJECT_SHIFT;
}

// A position in the image, in pixels, to a quarter.
uint pack_position(const vec2 position) {
    uvec2 quarters = uvec2(round(4.0 * position));
    return quarters.x | quarters.y << 16;
}

vec2 position_of(const uint packed) {
    return 0.25 * vec2(packed & 0xffffu, packed >> 16);
}

#endif
