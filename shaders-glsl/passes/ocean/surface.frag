#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel of the sea sees: a place on the water at rest, and how far the pixel reaches there. The filter pass reads the maps.
#include "../constants.glsl"

layout(location = 0) in vec2 in_rest;

layout(location = 0) out uvec4 out_texture; // place at rest, relative to the centre; its derivatives by x and y, metres
layout(location = 1) out uvec4 out_tangent;
layout(location = 2) out uvec4 out_surface; // the sea's index

void main() {
    vec2 dx = clamp(dFdx(in_rest), -6e4, 6e4), dy = clamp(dFdy(in_rest), -6e4, 6e4);
    out_texture = uvec4(floatBitsToUint(in_rest), packHalf2x16(dx), packHalf2x16(dy));
    out_tangent = uvec4(0u);
    out_surface = uvec4(SEA_INDEX << 24, 0u, 0u, 0u);
}
