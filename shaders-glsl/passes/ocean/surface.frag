#version 460
#extension GL_GOOGLE_include_directive : require
// The rest position of the sea under a pixel, and the pixel's footprint there. The filter pass reads the maps.
#include "../constants.glsl"
#define LEADR_FRAGMENT
#include "../reached.glsl"
#include "../visible.glsl"

layout(constant_id = 0) const int PIXELS = PIXELS_ARE_SAMPLES;

layout(location = 0) in vec2 in_rest;
layout(location = 1) centroid in vec2 in_rest_reached;
layout(location = 2) centroid in vec3 in_window;

layout(location = 0) out uvec4 out_surface;   // index and point in a multisampled pixel; rest position from the centre: visible_surface.rs
layout(location = 1) out uvec2 out_footprint; // its derivatives by x and y, metres

void main() {
    uint last = pack_position(gl_FragCoord.xy);
    if (PIXELS == PIXELS_ARE_EDGES) {
        last = 0u; // upward
    }
    vec2 rest = in_rest;
    uint location = 0u;
    if (PIXELS == PIXELS_ARE_MULTISAMPLED) {
        vec2 from_middle = in_window.xy / in_window.z - gl_FragCoord.xy;
        rest = in_rest_reached / perspective_at(from_middle, in_window.z);
        location = pack_location(from_middle);
        last = floatBitsToUint(gl_FragCoord.z);
    }
    out_surface = uvec4(SEA_INDEX << OBJECT_SHIFT | location, floatBitsToUint(rest), last);
    out_footprint = uvec2(packHalf2x16(clamp(dFdx(in_rest), -6e4, 6e4)), packHalf2x16(clamp(dFdy(in_rest), -6e4, 6e4)));
}
