// The image of objects: a depth for each object, so that an equal-depth test selects the pixels of an object before any shader
// runs.
#ifndef LEADR_OBJECT_DEPTH
#define LEADR_OBJECT_DEPTH
#include "visible.glsl"

// Depth without an object, beyond the pixels.
const float NOBODY_DEPTH = 1.0;

// object: from 1; 0 for the sky. A multiple of the 16-bit depth's step, so that rasterised depths equal those of fragment
// shaders on every device.
float object_depth(const uint object) {
    return float(object << (16u - OBJECT_BIT_COUNT)) / 65535.0;
}

// Corner of a triangle that covers the screen at that depth.
vec4 object_corner(const int vertex, const uint object) {
    return vec4(vec2(vertex & 1, vertex >> 1) * 4.0 - 1.0, object_depth(object), 1.0);
}

#endif
