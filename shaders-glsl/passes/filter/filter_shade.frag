#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Filters and shades each pixel or edge sample of one object in one pass, which is cheaper than a G-buffer when no other pass reads it. Pixels
// of other objects fail the depth test (object_depth.glsl), because drivers without divergent branches (lavapipe) continue
// after `discard`.
#include "filtered.glsl"
#define LEADR_CLASS_OPENNESS
#include "../shade/shaded.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    // The last word of an edge sample is its displacement direction.
    vec2 position = EDGES == EDGES_ARE_SHADED ? gl_FragCoord.xy : position_of(seen.w);
    float area;
    FilteredSurface filtered = filtered_mesh(pixel, position, seen, area);
    out_radiance = vec4(shaded(filtered, position, texelFetch(visible_depth, pixel, 0).x), 1.0);
}
