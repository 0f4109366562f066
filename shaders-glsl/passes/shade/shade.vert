#version 460
#extension GL_GOOGLE_include_directive : require
// The tiles that need shading: of edge samples those in which one is shaded for itself, of pixels those with objects or those
// without.
#include "settings.glsl"
#include "../tiles.glsl"

layout(constant_id = 11) const bool SKY = false; // tiles that show nothing but the sky

uniform usampler2D visible_surface;
layout(std430) readonly buffer TileRecords { uvec4 tile_records[]; };

void main() {
    uvec4 tile = tile_records[gl_VertexIndex];
    bool drawn = EDGES == EDGES_ARE_SHADED ? (tile.z & TILE_IS_SHADED) != 0u : ((tile.x | tile.y) == 0u) == SKY;
    gl_Position = tile_point(gl_VertexIndex, textureSize(visible_surface, 0), drawn);
    gl_PointSize = float(TILE_SIZE);
}
