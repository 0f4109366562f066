#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Filters and shades each pixel of one object: the G-buffer between the two costs more than it saves where nothing else reads it.
// The pixels of others fail the depth test (object_depth.glsl): drivers without divergent branches (lavapipe) go on after a `discard`.
#define LEADR_DETAIL // a tiling detail lies on the surface
#include "filtered.glsl"
#include "../shade/shaded.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    vec2 place = position_of(seen.w);
    float area;
    FilteredSurface filtered = filtered_mesh(pixel, place, seen, area);
    out_radiance = vec4(shaded(filtered, place, texelFetch(visible_depth, pixel, 0).x), 1.0);
}
