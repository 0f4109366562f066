// Edge samples: the mark of those on their pixel's own surface, and their rays (crates/leadr-render/src/passes/edges).
#ifndef LEADR_EDGES
#define LEADR_EDGES

const uint SURFACE_OF_THE_PIXEL = 1u; // needs no filtering: no object has the number 0

#ifdef LEADR_EDGE_RAYS
// Rays as in surface_at; x and y are the same for both samples.
layout(push_constant, std430) uniform EdgeRays {
    vec4 x;     // w: edge samples of each pixel
    vec4 y;
    vec4 pixel; // w: near plane
    vec4 edge;  // w: edge samples of each pixel that are already joined
    ivec4 area; // pixels that objects can cover: the first, and one past the last
} rays;

vec3 ray_across(const ivec2 pixel, const ivec2 size) {
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    return ndc.x * rays.x.xyz + ndc.y * rays.y.xyz;
}
#endif

#endif
