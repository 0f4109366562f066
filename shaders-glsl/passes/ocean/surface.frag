#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel of the sea sees: a place on the water at rest, and how far the pixel reaches there. The filter pass reads the maps.
#include "../constants.glsl"

layout(location = 0) in vec2 in_rest;

layout(location = 0) out uvec4 out_surface;   // the sea's index; place at rest, relative to the centre
layout(location = 1) out uvec2 out_footprint; // its derivatives by x and y, metres

void main() {
    out_surface = uvec4(SEA_INDEX << 24, floatBitsToUint(in_rest), 0u);
    out_footprint = uvec2(packHalf2x16(clamp(dFdx(in_rest), -6e4, 6e4)), packHalf2x16(clamp(dFdy(in_rest), -6e4, 6e4)));
}
