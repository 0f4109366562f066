// The word that tells what a pixel sees (VisibleSurface in src/render/passes/targets/visible_surface.rs): the patch in its
// low 24 bits, the object above.
#ifndef LEADR_VISIBLE
#define LEADR_VISIBLE

const uint PATCH_BITS = 0x00ffffffu;
const uint OBJECT_BITS = 0x3f000000u;    // from 1; 0 where nothing is
const uint OF_THE_PIXEL = 0x40000000u;   // an edge sample that sees the surface of its pixel (edges.comp)
const uint INSIDE = 0x80000000u;         // a back face, where those are marked

uint object_of(uint word) {
    return (word & OBJECT_BITS) >> 24;
}

#endif
