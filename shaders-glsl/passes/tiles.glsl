// Tiles of the screen, and what is seen in each: passes that concern some pixels draw the tiles that hold them
// (src/render/tiles.rs).
#ifndef LEADR_TILES
#define LEADR_TILES

const int TILE_SIZE = 16; // pixels

// Record of a tile: a bit for each object in it, by number, and whether any sample in it is shaded for itself (edges.comp
// marks those that are not).
const uint TILE_IS_SHADED = 1u; // z

bool tile_shows(uvec4 record, uint object) {
    return ((object < 32u ? record.x : record.y) >> (object & 31u) & 1u) != 0u;
}

int tile_columns(ivec2 size) {
    return (size.x + TILE_SIZE - 1) / TILE_SIZE;
}

// Place of the point of TILE_SIZE pixels that covers a tile, in a viewport of whole tiles. Two triangles would shade the pixels along
// their diagonal twice over. Those that are not drawn are out of sight.
vec4 tile_point(int tile, ivec2 size, bool drawn) {
    int columns = tile_columns(size), rows = (size.y + TILE_SIZE - 1) / TILE_SIZE;
    vec2 middle = (vec2(tile % columns, tile / columns) + 0.5) / vec2(columns, rows);
    return vec4(drawn ? middle * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}

#endif
