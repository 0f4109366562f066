// Screen tiles and their contents. A pass for some of the pixels draws only the tiles that contain such pixels
// (crates/leadr-render/src/passes/targets/tiles.rs).
#ifndef LEADR_TILES
#define LEADR_TILES
#include "constants.glsl"

// The record of a tile. xy has a bit for each object in the tile; objects whose numbers are 64 apart share a bit. z has flags.
const uint TILE_IS_SHADED = 1u;  // contains a sample to shade (edges.comp marks all other samples)
const uint TILE_SHOWS_SKY = 2u;

uvec2 tile_bit(const uint object) {
    uint bit = 1u << (object & 31u);
    return (object & 32u) == 0u ? uvec2(bit, 0u) : uvec2(0u, bit);
}

bool tile_shows(const uvec4 record, const uint object) {
    return (record.xy & tile_bit(object)) != uvec2(0u);
}

int tile_columns(const ivec2 size) {
    return (size.x + TILE_SIZE - 1) / TILE_SIZE;
}

// Returns the position of a point primitive, TILE_SIZE pixels wide, that covers a tile. The viewport is a whole number of tiles. Two
// triangles would shade the pixels along their diagonal twice. Skipped tiles get a position outside the screen.
vec4 tile_point(const int tile, const ivec2 size, const bool drawn) {
    int columns = tile_columns(size), rows = (size.y + TILE_SIZE - 1) / TILE_SIZE;
    vec2 middle = (vec2(tile % columns, tile / columns) + 0.5) / vec2(columns, rows);
    return vec4(drawn ? middle * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}

#endif
