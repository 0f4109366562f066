#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Filters and shades each pixel of the sea. Other pixels fail the depth test.
#include "filtered.glsl"
#include "../shade/shaded.glsl"

uniform sampler2D visible_depth;

layout(early_fragment_tests) in;
layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    FilteredSurface filtered = filtered_sea(pixel, seen);
    out_radiance = vec4(shaded(filtered, position_of(seen.w), texelFetch(visible_depth, pixel, 0).x), 1.0);
}
