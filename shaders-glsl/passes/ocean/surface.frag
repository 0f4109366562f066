#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the rest position of the sea under a pixel, and the pixel's footprint at this position. The filter pass reads the maps.
#include "../constants.glsl"
#define LEADR_FRAGMENT
#include "../reached.glsl"
#include "../visible.glsl"

layout(constant_id = 0) const int PIXELS = PIXELS_ARE_SAMPLES;

layout(location = 0) in vec2 in_rest;
layout(location = 1) centroid in vec2 in_rest_reached;
layout(location = 2) centroid in vec3 in_window;
layout(location = 3) in flat vec4 in_patch_bounds;

layout(location = 0) out uvec4 out_surface;   // index, and point in a multisampled pixel; rest position relative to the centre
layout(location = 1) out uvec2 out_footprint; // derivatives of the rest position by x and y, in metres

// A vector shortened to a length. `along` may hold infinities or no number.
vec2 bounded(const vec2 along, const float most) {
    vec2 finite = min(max(along, -6e4), 6e4);
    return finite * min(most / max(length(finite), 1e-20), 1.0);
}

void main() {
    uint last = pack_position(gl_FragCoord.xy);
    if (PIXELS == PIXELS_ARE_EDGES) {
        last = 0u; // upward direction
    }
    vec2 rest = in_rest;
    uint location = 0u;
    if (PIXELS == PIXELS_ARE_MULTISAMPLED) {
        vec2 from_middle = in_window.xy / in_window.z - gl_FragCoord.xy;
        rest = in_rest_reached / perspective_at(from_middle, in_window.z);
        // At the horizon, interpolation loses all digits: positions leave the pixel and the patch, or are not numbers.
        bool sound = abs(from_middle.x) < 0.75 && abs(from_middle.y) < 0.75 && dot(rest, rest) < 1e12;
        from_middle = sound ? from_middle : vec2(0.0);
        rest = sound ? clamp(rest, in_patch_bounds.xy, in_patch_bounds.zw) : 0.5 * (in_patch_bounds.xy + in_patch_bounds.zw);
        location = pack_location(from_middle);
        last = floatBitsToUint(gl_FragCoord.z);
    }
    out_surface = uvec4(SEA_INDEX << OBJECT_SHIFT | location, floatBitsToUint(rest), last);
    // A neighbour may lie above the horizon, where interpolated positions mean nothing. No pixel covers more than its distance.
    float most = min(length(rest), 6e4);
    out_footprint = uvec2(packHalf2x16(bounded(dFdx(in_rest), most)), packHalf2x16(bounded(dFdy(in_rest), most)));
}
