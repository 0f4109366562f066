#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the depth of an alpha-masked surface for shadow maps.
#include "object.glsl"
#include "cutout.glsl"

layout(location = 0) in vec2 in_patch_uv;
layout(location = 2) in flat uint in_patch;

void main() {
    if (opacity_at(in_patch, in_patch_uv, dFdx(in_patch_uv), dFdy(in_patch_uv)) <= first_threshold(in_patch)) {
        discard;
    }
}
