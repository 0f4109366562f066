#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the tiles that need shading. For edge samples, tiles with at least one sample to shade are drawn. For pixels, tiles with objects
// are drawn. Objects with several classes of facets are shaded by their own filter pass, so tiles with nothing else are not drawn.
#include "settings.glsl"
#include "../tiles.glsl"

uniform usampler2D visible_surface;
layout(std430) readonly buffer TileRecords { uvec4 tile_records[]; };
layout(push_constant, std430) uniform ObjectsByClass { uvec2 by_class; };

void main() {
    uvec4 tile = tile_records[gl_VertexIndex];
    bool others = (tile.xy & ~by_class) != uvec2(0u);
    bool drawn = EDGES == EDGES_ARE_SHADED ? (tile.z & TILE_IS_SHADED) != 0u && (others || (tile.z & TILE_SHOWS_SKY) != 0u) : others;
    gl_Position = tile_point(gl_VertexIndex, textureSize(visible_surface, 0), drawn);
    gl_PointSize = float(TILE_SIZE);
}
