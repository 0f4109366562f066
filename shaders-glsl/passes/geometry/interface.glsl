// What the four stages of the geometry pass share: buffers, and the point-normal patch of src/render/surfaces/patch.rs.
#ifndef LEADR_GEOMETRY_INTERFACE
#define LEADR_GEOMETRY_INTERFACE

#include "../constants.glsl"

struct Vertex {
    vec4 position; // xyz metres; w: ambient accessibility
    vec4 normal;   // xyz unit displacement direction; w: LOD of the heights at this vertex
    vec4 color;    // rgb linear albedo; a: Beckmann roughness alpha
};

struct PatchData {
    uvec4 vertices;   // corners (0,0) (1,0) (1,1) (0,1)
    uvec4 edges;      // edge index << 1 | 1 when the patch runs along it backwards
    vec4 texcoord_01; // texture coordinates of corners 0 and 1
    vec4 texcoord_23; // … and of corners 3 and 2: the row v = 1 in the same order
    vec4 tile;        // texture-space bounds the taps must stay in: min.xy, max.xy
};

layout(std430) readonly buffer Vertices { Vertex vertices[]; };
layout(std430) readonly buffer Patches { PatchData patches[]; };
layout(std430) readonly buffer EdgeFactors { float edge_factors[]; };
layout(std430) readonly buffer EdgeHeights { float edge_heights[]; };
layout(std430) readonly buffer VertexHeights { float vertex_heights[]; };
layout(std430) readonly buffer VisiblePatches { uint visible_patches[]; };
uniform sampler2D height_map;
#include "object.glsl"
#include "view.glsl"

// Inner Bezier point beside `a` on the boundary from `a` to `b`. Precise: both patches of an edge get the same bits.
vec3 edge_point(vec3 a, vec3 normal_a, vec3 b) {
    precise vec3 chord = (b - a) / 3.0;
    precise float drop = chord.x * normal_a.x + chord.y * normal_a.y + chord.z * normal_a.z;
    precise vec3 point = a + chord - normal_a * drop;
    return point;
}

#endif
