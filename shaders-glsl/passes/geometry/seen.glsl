// The output of the geometry pass for a position on an object.
#ifndef LEADR_GEOMETRY_SEEN
#define LEADR_GEOMETRY_SEEN

#include "object.glsl"
#include "footprint.glsl"
#define LEADR_FRAGMENT
#include "../reached.glsl"
#include "../visible.glsl"

layout(constant_id = 0) const int PIXELS = PIXELS_ARE_SAMPLES;

layout(location = 0) in vec2 in_patch_uv;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in flat uint in_patch;
layout(location = 3) centroid in vec2 in_patch_uv_reached;
layout(location = 4) centroid in vec3 in_window;

layout(location = 0) out uvec4 out_surface;   // object and patch; position (see visible_surface.rs)
layout(location = 1) out uvec2 out_footprint; // footprint of an edge sample; for multisampled pixels, see reached.glsl

void write_seen() {
    // A triangle that is seen exactly edge-on can be rasterised with a meaningless depth. No valid point lies at or before the near plane.
    bool broken = PIXELS != PIXELS_ARE_MULTISAMPLED && !(gl_FragCoord.z < 1.0);
    bool inside = (OBJECT.flags & (FLAG_MARK_INSIDE | FLAG_TRIANGLES)) != 0u && !gl_FrontFacing;
    uint seen = broken ? 0u : OBJECT.number << OBJECT_SHIFT | (in_patch & PATCH_BITS) | (inside ? INSIDE : 0u);
    vec2 patch_uv = in_patch_uv;
    uint last = pack_position(gl_FragCoord.xy);
    if (PIXELS == PIXELS_ARE_EDGES) {
        last = packSnorm2x16(octahedral_encode(normalize(in_normal)));
        // The footprint is scaled to a whole pixel.
        float across = float(VIEW.edge_grid);
        out_footprint = pack_footprint(dFdx(in_patch_uv) * across, dFdy(in_patch_uv) * across);
    }
    if (PIXELS == PIXELS_ARE_MULTISAMPLED) {
        // A triangle does not always cover the centre of the pixel, so the stored position is a point that the triangle covers.
        vec2 location = in_window.xy / in_window.z - gl_FragCoord.xy;
        patch_uv = in_patch_uv_reached / perspective_at(location, in_window.z);
        bool on_patch = (OBJECT.flags & FLAG_FLAT) != 0u || clamp(in_patch_uv, 0.0, 1.0) == in_patch_uv;
        seen |= on_patch ? 0u : BESIDE;
        last = floatBitsToUint(gl_FragCoord.z);
        out_footprint = pack_reached(location, normalize(in_normal), patch_uv - in_patch_uv);
    }
    out_surface = uvec4(seen, floatBitsToUint(patch_uv), last);
}

#endif
