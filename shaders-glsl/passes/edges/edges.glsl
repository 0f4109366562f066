// Edge samples: the mark of samples on their pixel's own surface, and the rays through the samples (crates/leadr-render/src/passes/edges).
#ifndef LEADR_EDGES
#define LEADR_EDGES

const uint SURFACE_OF_THE_PIXEL = 1u; // The sample needs no filtering. No object has the number 0.

#ifdef LEADR_EDGE_RAYS
// Rays as in surface_at. The x and y vectors are the same for pixels and for edge samples.
layout(push_constant, std430) uniform EdgeRays {
    vec4 x;     // w: number of edge samples in each pixel
    vec4 y;
    vec4 pixel; // w: near plane
    vec4 edge;  // w: number of edge samples in each pixel that are already joined
    ivec4 area; // rectangle of pixels that objects can cover: the first pixel, and one past the last
} rays;

vec3 ray_across(const ivec2 pixel, const ivec2 size) {
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    return ndc.x * rays.x.xyz + ndc.y * rays.y.xyz;
}
#endif

#endif
