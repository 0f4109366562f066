// What the geometry pass writes of a place on an object.
#ifndef LEADR_GEOMETRY_SEEN
#define LEADR_GEOMETRY_SEEN

#include "object.glsl"
#include "place.glsl"
#define LEADR_FRAGMENT
#include "../reached.glsl"
#include "../visible.glsl"

layout(constant_id = 0) const int PIXELS = PIXELS_ARE_SAMPLES;

layout(location = 0) in vec2 in_place;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in flat uint in_patch;
layout(location = 3) centroid in vec2 in_place_reached;
layout(location = 4) centroid in vec3 in_window;

layout(location = 0) out uvec4 out_surface;   // object and patch; place; see visible_surface.rs
layout(location = 1) out uvec2 out_footprint; // of an edge sample; of a multisampled pixel see reached.glsl

void write_seen() {
    // A triangle seen exactly edge-on can be rasterised with a meaningless depth: nothing lies at or before the near plane.
    bool broken = PIXELS != PIXELS_ARE_MULTISAMPLED && !(gl_FragCoord.z < 1.0);
    bool inside = (OBJECT.flags & (FLAG_MARK_INSIDE | FLAG_TRIANGLES)) != 0u && !gl_FrontFacing;
    uint seen = broken ? 0u : OBJECT.number << OBJECT_SHIFT | (in_patch & PATCH_BITS) | (inside ? INSIDE : 0u);
    vec2 place = in_place;
    uint last = pack_position(gl_FragCoord.xy);
    if (PIXELS == PIXELS_ARE_EDGES) {
        last = packSnorm2x16(octahedral_encode(normalize(in_normal)));
        // Over a whole pixel.
        float across = VIEW.grid;
        out_footprint = pack_footprint(dFdx(in_place) * across, dFdy(in_place) * across);
    }
    if (PIXELS == PIXELS_ARE_MULTISAMPLED) {
        // A triangle need not reach the middle of the pixel: the place is one that it does reach.
        vec2 location = in_window.xy / in_window.z - gl_FragCoord.xy;
        place = in_place_reached / perspective_at(location, in_window.z);
        bool on_patch = (OBJECT.flags & FLAG_FLAT) != 0u || clamp(in_place, 0.0, 1.0) == in_place;
        seen |= on_patch ? 0u : BESIDE;
        last = floatBitsToUint(gl_FragCoord.z);
        out_footprint = pack_reached(location, normalize(in_normal), place - in_place);
    }
    out_surface = uvec4(seen, floatBitsToUint(place), last);
}

#endif
