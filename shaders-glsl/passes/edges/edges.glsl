// Edge samples: how one says that it sees the surface its pixel is shaded by, and their rays (src/render/edges.rs).
#ifndef LEADR_EDGES
#define LEADR_EDGES

const uint SURFACE_OF_THE_PIXEL = 1u; // and needs no filtering of its own: no object has the number 0

#ifdef LEADR_EDGE_RAYS
// Rays as in read_gbuffer; x and y are the same for both samples.
layout(push_constant, std430) uniform EdgeRays {
    vec4 x;     // w: edge samples of each pixel
    vec4 y;
    vec4 pixel; // w: near plane
    vec4 edge;  // w: edge samples that were joined before, in each pixel
    ivec4 area; // of the pixels that objects can be in: first, and beyond the last
} rays;

vec3 ray_across(ivec2 pixel, ivec2 size) {
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    return ndc.x * rays.x.xyz + ndc.y * rays.y.xyz;
}
#endif

#endif
