#version 460
#extension GL_GOOGLE_include_directive : require
// The tiles in which edge samples are shaded.
#include "../tiles.glsl"

layout(binding = 9) uniform usampler2D visible_surface;
layout(binding = 10, std430) readonly buffer TileRecords { uvec4 tile_records[]; };

void main() {
    bool shaded = (tile_records[gl_VertexIndex].z & TILE_IS_SHADED) != 0u;
    gl_Position = tile_point(gl_VertexIndex, textureSize(visible_surface, 0), shaded);
    gl_PointSize = float(TILE_SIZE);
}
