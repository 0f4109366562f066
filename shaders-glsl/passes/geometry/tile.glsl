// Keeps filter taps inside a tile of an atlas.
#ifndef LEADR_GEOMETRY_TILE
#define LEADR_GEOMETRY_TILE

// Moves a texture coordinate so that a trilinear tap at `lod` reads no texel outside `tile` (min.xy, max.xy in texture space). For maps
// that wrap, pass an enormous tile. Up to level 2, the gutter makes the result exact.
vec2 clamp_to_tile(const vec2 texcoord, const vec4 tile, const float lod, const ivec2 size) {
    vec2 half_texel = min(exp2(ceil(lod)) * 0.5 / vec2(size), 0.5 * (tile.zw - tile.xy));
    return clamp(texcoord, tile.xy + half_texel, tile.zw - half_texel);
}

#endif
