#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Filters the maps of one object under each of its pixels.
#include "filtered.glsl"
#include "gbuffer_out.glsl"

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    if (object_of(seen.x) != OBJECT.number) {
        discard;
    }
    float area;
    FilteredSurface filtered = filtered_mesh(pixel, gl_FragCoord.xy, seen, area);
    bool of_an_edge = VIEW.edge_grid > 0u;
    uvec2 surface = of_an_edge ? pack_edge(filtered) : pack_surface(filtered);
    write_gbuffer(filtered, (seen.x & OF_THE_PIXEL) != 0u ? pack_joined_edge(area, filtered.relief) : surface);
}
