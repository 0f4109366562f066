// The word that tells what a pixel sees (VisibleSurface in crates/leadr-render/src/passes/targets/visible_surface.rs): the patch in its
// low bits, the object above; how many bits each has depends on how many objects the scene has (surfaces/numbering.rs). The third word
// after it tells where in the picture that is.
#ifndef LEADR_VISIBLE
#define LEADR_VISIBLE

layout(constant_id = 90) const uint OBJECT_BIT_COUNT = 6u;

const uint OBJECT_SHIFT = 30u - OBJECT_BIT_COUNT;
const uint PATCH_BITS = (1u << OBJECT_SHIFT) - 1u;
const uint OBJECT_BITS = 0x3fffffffu - PATCH_BITS; // from 1; 0 where nothing is
const uint SEA_INDEX = (1u << OBJECT_BIT_COUNT) - 1u; // the last object
const uint OF_THE_PIXEL = 0x40000000u;   // an edge sample that sees the surface of its pixel (edges.comp)
const uint INSIDE = 0x80000000u;         // a back face of triangles, or where those are marked
const uint BESIDE = 0x40000000u;         // a sample whose place in the middle of the pixel is off its patch (msaa.comp)
const uint NOBODY = 0xffffffffu;         // not a pixel (msaa.comp)

// Points that a pixel sees of one object are one surface if they differ along their normal by less than a pixel, and the cosine of the
// angle between their displacement directions is above this.
const float SAME_NORMAL = 0.9;

uint object_of(const uint word) {
    return (word & OBJECT_BITS) >> OBJECT_SHIFT;
}

// A place in the picture, in pixels, to a quarter.
uint pack_position(const vec2 position) {
    uvec2 quarters = uvec2(round(4.0 * position));
    return quarters.x | quarters.y << 16;
}

vec2 position_of(const uint packed) {
    return 0.25 * vec2(packed & 0xffffu, packed >> 16);
}

#endif
