// What a cascade is (crates/leadr-render/src/surfaces/ocean/waves.rs).
#ifndef LEADR_OCEAN_CASCADE
#define LEADR_OCEAN_CASCADE

struct Cascade {
    vec2 turn;       // cosine and sine of the tile's angle in the world
    float wave_step; // 2 pi / size, rad/m
    float size;      // of the tile, metres
};

// Texture coordinate of a world point.
vec2 cascade_texcoord(const Cascade c, const vec2 point) {
    return vec2(c.turn.x * point.x + c.turn.y * point.y, c.turn.x * point.y - c.turn.y * point.x) / c.size;
}

// Gradient per world metre into texture coordinates: how far a world vector reaches across the tile.
vec2 cascade_vector(const Cascade c, const vec2 v) {
    return cascade_texcoord(c, v);
}

// The weight of a cascade's horizontal divergence in the foam (crates/leadr-render/src/surfaces/ocean/waves.rs): ripples trap no air, but
// tear apart the foam of longer waves.
float foam_weight(const Cascade c) {
    return c.size >= 10.0 ? 1.0 : 0.35;
}

#endif
