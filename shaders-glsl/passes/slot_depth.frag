#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the object of each slot below the pixels, encoded as a depth (msaa.comp).
#include "msaa.glsl"
#include "object_depth.glsl"
#include "visible.glsl"

uniform usampler2D visible_surface;
layout(std430) readonly buffer FilledSlots { uint filled_slots[]; }; // number of filled slots in each block

layout(depth_any) out float gl_FragDepth;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy), size = textureSize(visible_surface, 0);
    ivec2 block = (texel - ivec2(0, size.y / 2)) / OTHERS_BLOCK;
    bool filled = slot_of_texel(texel) < int(filled_slots[block.y * (size.x / OTHERS_BLOCK) + block.x]);
    gl_FragDepth = filled ? object_depth(object_of(texelFetch(visible_surface, texel, 0).x)) : NOBODY_DEPTH;
}
