#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel sees: the patch, and where on it. Small triangles run this stage several times per pixel, so it reads nothing and
// works nothing out: the filter pass does that, once per pixel.
#include "object.glsl"
#include "place.glsl"
#include "view.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"

layout(constant_id = 0) const bool EDGES = false; // whether the pixels are edge samples

layout(location = 0) in vec2 in_place;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in flat uint in_patch;

layout(location = 0) out uvec4 out_surface;   // object and patch; place; displacement direction of an edge sample
layout(location = 1) out uvec2 out_footprint; // of an edge sample

void main() {
    // A triangle seen exactly edge-on can be rasterised with a meaningless depth: nothing lies at or before the near plane.
    bool broken = !(gl_FragCoord.z < 1.0);
    bool inside = (object.flags & FLAG_MARK_INSIDE) != 0u && !gl_FrontFacing;
    uint seen = broken ? 0u : object.index << 24 | (in_patch & PATCH_BITS) | (inside ? INSIDE : 0u);
    uint direction = 0u;
    if (EDGES) {
        direction = packSnorm2x16(octahedral_encode(normalize(in_normal)));
        // Over a whole pixel.
        float across = view.camera_position.w;
        out_footprint = pack_footprint(dFdx(in_place) * across, dFdy(in_place) * across);
    }
    out_surface = uvec4(seen, floatBitsToUint(in_place), direction);
}
