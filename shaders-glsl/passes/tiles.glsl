// Screen tiles and their contents: a pass for some pixels draws only the tiles that contain them
// (crates/leadr-render/src/passes/targets/tiles.rs).
#ifndef LEADR_TILES
#define LEADR_TILES
#include "constants.glsl"

// Record of a tile. xy: a bit for each object that it shows; objects whose numbers are 64 apart share one. z: flags.
const uint TILE_IS_SHADED = 1u; // contains a sample to shade (edges.comp marks the others)

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

// Position of a point, TILE_SIZE pixels wide, that covers a tile; the viewport is a whole number of tiles. Two triangles would
// shade the pixels along their diagonal twice. Skipped tiles get a position off the screen.
vec4 tile_point(const int tile, const ivec2 size, const bool drawn) {
    int columns = tile_columns(size), rows = (size.y + TILE_SIZE - 1) / TILE_SIZE;
    vec2 middle = (vec2(tile % columns, tile / columns) + 0.5) / vec2(columns, rows);
    return vec4(drawn ? middle * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}

#endif
