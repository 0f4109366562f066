#version 460
#extension GL_GOOGLE_include_directive : require
// Records the contents of each screen tile.
#include "edges/edges.glsl"
#include "tiles.glsl"
#include "visible.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler2D visible_surface;
layout(std430) writeonly buffer Tiles { uvec4 tiles[]; };

shared uint low, high, flags;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        low = high = flags = 0u;
    }
    barrier();
    ivec2 size = textureSize(visible_surface, 0), tile = ivec2(gl_WorkGroupID.xy);
    uvec3 seen = uvec3(0u);
    for (int i = 0; i < 4; ++i) {
        ivec2 at = tile * TILE_SIZE + ivec2(gl_LocalInvocationID.xy) + ivec2(i & 1, i >> 1) * (TILE_SIZE / 2);
        uint word = texelFetch(visible_surface, min(at, size - 1), 0).x, object = object_of(word);
        bool shaded = word != SURFACE_OF_THE_PIXEL && (word & OF_THE_PIXEL) == 0u;
        uint flag = shaded ? (object == 0u ? TILE_IS_SHADED | TILE_SHOWS_SKY : TILE_IS_SHADED) : 0u;
        seen |= uvec3(object == 0u ? uvec2(0u) : tile_bit(object), flag);
    }
    atomicOr(low, seen.x);
    atomicOr(high, seen.y);
    atomicOr(flags, seen.z);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        tiles[tile.y * tile_columns(size) + tile.x] = uvec4(low, high, flags, 0u);
    }
}
