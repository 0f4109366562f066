// A cascade of waves (crates/leadr-render/src/surfaces/ocean/waves.rs).
#ifndef LEADR_OCEAN_CASCADE
#define LEADR_OCEAN_CASCADE

struct Cascade {
    vec2 rotation;   // cosine and sine of the tile's angle in the world
    float wave_step; // 2 pi / size in rad/m
    float size;      // size of the tile in metres
};

// Returns the texture coordinate of a world point.
vec2 cascade_texcoord(const Cascade c, const vec2 point) {
    return vec2(c.rotation.x * point.x + c.rotation.y * point.y, c.rotation.x * point.y - c.rotation.y * point.x) / c.size;
}

// Transforms a world vector to texture coordinates, as the vector's extent across the tile.
vec2 cascade_vector(const Cascade c, const vec2 v) {
    return cascade_texcoord(c, v);
}

// Returns the weight of a cascade's horizontal divergence in the foam (crates/leadr-render/src/surfaces/ocean/waves.rs). Ripples trap no
// air, but they tear the foam of longer waves.
float foam_weight(const Cascade c) {
    return c.size >= 10.0 ? 1.0 : 0.35;
}

#endif
