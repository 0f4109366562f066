#version 460
#extension GL_GOOGLE_include_directive : require
// The depth of a surface with holes, for the maps of lights.
#include "object.glsl"
#include "holes.glsl"

layout(location = 0) in vec2 in_place;
layout(location = 2) in flat uint in_patch;

void main() {
    if (opacity_at(in_patch, in_place, dFdx(in_place), dFdy(in_place)) <= first_threshold(in_patch)) {
        discard;
    }
}
