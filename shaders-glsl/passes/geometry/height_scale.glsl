// A height scale that varies over the surface (LEADR section 4.2): a map over the texture coordinates, times a factor per vertex.
// crates/leadr-render/src/surfaces/height_scale.rs is the twin for edges.
#ifndef LEADR_GEOMETRY_HEIGHT_SCALE
#define LEADR_GEOMETRY_HEIGHT_SCALE
#include "../constants.glsl"
#include "object.glsl"
#include "patch.glsl"

layout(constant_id = 91) const uint HEIGHT_TERMS = 0u; // HEIGHT_ bits
const bool SCALED_BY_MAP = (HEIGHT_TERMS & HEIGHT_SCALED_BY_MAP) != 0u;
const bool HEIGHT_SCALED = (HEIGHT_TERMS & (HEIGHT_SCALED_BY_MAP | HEIGHT_SCALED_BY_VERTEX)) != 0u;
const bool SCALED_BY_VERTEX = (HEIGHT_TERMS & HEIGHT_SCALED_BY_VERTEX) != 0u;
// For an atlas, the coarse levels of moments_a (atlas.glsl). Otherwise the map of the height scale: x: mean; y: variance in the texel.
layout(set = 2) uniform sampler2D coarse_a;

vec2 height_scale_texcoord(const vec2 texcoord) {
    precise vec2 at = OBJECT.scale_linear.xy * texcoord.x + OBJECT.scale_linear.zw * texcoord.y + OBJECT.scale_offset;
    return at;
}

// Returns the factor on the height that a vertex reads at this level of detail of the heights. of_vertices is the factor of the vertices.
float height_scale(const vec2 texcoord, const float lod, const float of_vertices) {
    precise float scale = SCALED_BY_VERTEX ? of_vertices : 1.0;
    if (SCALED_BY_MAP) {
        scale *= textureLod(coarse_a, height_scale_texcoord(texcoord), max(lod + OBJECT.scale_lod, 0.0)).x;
    }
    return scale;
}

// The factors at the corners of a patch; the third and fourth of a triangle are alike.
vec4 corner_height_scales(const PatchData data) {
    uvec4 corner = data.vertices;
    return vec4(vertices[corner.x].facing.w, vertices[corner.y].facing.w, vertices[corner.z].facing.w, vertices[corner.w].facing.w);
}

float quad_height_scale(const vec4 corners, const vec2 patch_uv) {
    return mix(mix(corners.x, corners.y, patch_uv.x), mix(corners.w, corners.z, patch_uv.x), patch_uv.y);
}

vec2 quad_height_scale_by_uv(const vec4 corners, const vec2 patch_uv) {
    return vec2(mix(corners.y - corners.x, corners.z - corners.w, patch_uv.y), mix(corners.w - corners.x, corners.z - corners.y, patch_uv.x));
}

float triangle_height_scale(const vec4 corners, const vec2 patch_uv) {
    return corners.x + dot(vec2(corners.y, corners.w) - corners.x, patch_uv);
}

#endif
