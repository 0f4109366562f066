// How an edge sample says that it sees the surface its pixel is shaded by (edges.comp).
#ifndef LEADR_EDGES
#define LEADR_EDGES

const uint SURFACE_OF_THE_PIXEL = 1u; // no object has the number 0, so nothing filters it
const vec4 RADIANCE_OF_THE_PIXEL = vec4(0.0, 0.0, 0.0, -1.0);

#endif
