#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the tiles that need shading. For edge samples, tiles with at least one sample to shade are drawn. For pixels, tiles with objects
// are drawn.
#include "settings.glsl"
#include "../tiles.glsl"

uniform usampler2D visible_surface;
layout(std430) readonly buffer TileRecords { uvec4 tile_records[]; };

void main() {
    uvec4 tile = tile_records[gl_VertexIndex];
    bool drawn = EDGES == EDGES_ARE_SHADED ? (tile.z & TILE_IS_SHADED) != 0u
                                           : (tile.x | tile.y) != 0u;
    gl_Position = tile_point(gl_VertexIndex, textureSize(visible_surface, 0), drawn);
    gl_PointSize = float(TILE_SIZE);
}
