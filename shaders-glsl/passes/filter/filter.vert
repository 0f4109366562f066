#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the tiles that contain an object.
#include "../geometry/object.glsl"
#include "../tiles.glsl"

uniform usampler2D visible_surface;
layout(std430) readonly buffer TileRecords { uvec4 tile_records[]; };

void main() {
    bool seen = tile_shows(tile_records[gl_VertexIndex], OBJECT.number);
    gl_Position = tile_point(gl_VertexIndex, textureSize(visible_surface, 0), seen);
    gl_PointSize = float(TILE_SIZE);
}
