#version 460
#extension GL_GOOGLE_include_directive : require
// Filters the waves under each pixel of the sea.
#include "filtered.glsl"
#include "../filter/gbuffer_out.glsl"

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    if (object_of(seen.x) != SEA_INDEX) {
        discard;
    }
    FilteredSurface sea = filtered_sea(pixel, seen);
    write_gbuffer(sea, pack_surface(sea));
}
