// The image of objects encodes each object as a depth, so that a depth test for equality selects the pixels of an object before any shader
// runs.
#ifndef LEADR_OBJECT_DEPTH
#define LEADR_OBJECT_DEPTH
#include "visible.glsl"

// The depth of texels that belong to no pixel.
const float NOBODY_DEPTH = 1.0;

// Returns the depth of an object. Objects count from 1, and 0 is the sky. The depth is a multiple of the step of 16-bit depths, so that
// depths from rasterisation and from fragment shaders are equal on every device.
float object_depth(const uint object) {
    return float(object << (16u - OBJECT_BIT_COUNT)) / 65535.0;
}

// Returns a corner of a triangle that covers the screen at the depth of an object.
vec4 object_corner(const int vertex, const uint object) {
    return vec4(vec2(vertex & 1, vertex >> 1) * 4.0 - 1.0, object_depth(object), 1.0);
}

#endif
