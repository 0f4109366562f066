// The image of objects: a depth for each object, so that a test for equal depths picks the pixels that show it before anything runs
// for them.
#ifndef LEADR_OBJECT_DEPTH
#define LEADR_OBJECT_DEPTH
#include "visible.glsl"

// Where no pixel is: no object has it.
const float NOBODY_DEPTH = 1.0;

// object: from 1; 0 for the sky. A multiple of the depth's 16 bits, so that what rasterisation rounds and what a fragment stage
// writes are equal on every device.
float object_depth(const uint object) {
    return float(object << (16u - OBJECT_BIT_COUNT)) / 65535.0;
}

// Corner of a triangle that covers the screen at that depth.
vec4 object_corner(const int vertex, const uint object) {
    return vec4(vec2(vertex & 1, vertex >> 1) * 4.0 - 1.0, object_depth(object), 1.0);
}

#endif
