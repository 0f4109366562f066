// The interface between the stages of the geometry pass.
#ifndef LEADR_GEOMETRY_INTERFACE
#define LEADR_GEOMETRY_INTERFACE

#include "../constants.glsl"
#include "object.glsl"
#include "patch.glsl"
#include "detail_height.glsl"

layout(std430) readonly buffer EdgeFactors { float edge_factors[]; };
layout(set = 2, std430) readonly buffer EdgeHeights { float edge_heights[]; };
layout(set = 2, std430) readonly buffer VertexHeights { float vertex_heights[]; };
layout(std430) readonly buffer VisiblePatches { uint visible_patches[]; };
layout(set = 2) uniform sampler2D height_map;

#endif
