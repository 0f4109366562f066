// The heights of a detail that displaces the surface, over texture coordinates (passes/filter/detail.glsl).
// crates/leadr-render/src/surfaces/height_scale.rs is the twin for edges.
#ifndef LEADR_GEOMETRY_DETAIL_HEIGHT
#define LEADR_GEOMETRY_DETAIL_HEIGHT
#include "height_scale.glsl"

const bool DETAIL_DISPLACES = (HEIGHT_TERMS & HEIGHT_WITH_DETAIL) != 0u;

struct RestVertex {
    vec4 position; // xyz in repeats of the surface's own textures
    vec4 normal;   // xyz
};

layout(set = 2, std430) readonly buffer Detail {
    vec4 detail_linear;   // columns of the matrix from the surface's coordinates to the coordinates of the detail
    vec4 mask_linear;     // columns of the matrix from the surface's coordinates to the coordinates of the mask
    vec4 detail_offsets;  // xy: offset of the detail; zw: offset of the mask
    vec4 detail_color;    // rgb: factor on the colours of the detail; a: its reflectance at normal incidence
    RestVertex rest[];    // only for details projected along the axes
};
layout(set = 2) uniform sampler2D detail_mask;  // x: mean coverage, E[m]; y: E[m^2]
layout(set = 2) uniform sampler2D coarse_b; // for an atlas, the coarse levels of moments_b; otherwise the heights of the detail, in metres

// Returns the height in units of height_map. lod is the level of detail of height_map at the spacing of the samples, which may be negative.
float detail_height(const vec2 texcoord, const float lod) {
    precise vec2 at = detail_linear.xy * texcoord.x + detail_linear.zw * texcoord.y + detail_offsets.xy;
    float height = textureLod(coarse_b, at, max(lod + OBJECT.detail_lod, 0.0)).x * OBJECT.detail_unit;
    precise vec2 there = mask_linear.xy * texcoord.x + mask_linear.zw * texcoord.y + detail_offsets.zw;
    return height * textureLod(detail_mask, there, 0.0).x;
}

// Returns the height of the surface where the map has this height: times the height scale, plus the detail. spacing is the unclamped level of
// detail, and of_vertices is the factor of the vertices.
float whole_height(const float height, const vec2 texcoord, const float spacing, const float of_vertices) {
    precise float whole = height * height_scale(texcoord, max(spacing, 0.0), of_vertices);
    if (DETAIL_DISPLACES) {
        whole += detail_height(texcoord, spacing);
    }
    return whole;
}

#endif
