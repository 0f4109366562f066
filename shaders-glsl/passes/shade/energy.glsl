// The energy tables for leadr/materials/energy.glsl: first of GGX facets, then of Beckmann facets.
#ifndef LEADR_SHADE_ENERGY
#define LEADR_SHADE_ENERGY
#include "../technique.glsl"

layout(set = 1, std430) readonly buffer Energies { vec2 energies[]; };

vec2 energy_texel(const int x, const int y) {
    const uint TABLE = 33u * 48u; // number of texels in a table
    return energies[(GGX_BASE ? 0u : TABLE) + uint(33 * y + x)];
}
#define LEADR_ENERGY_TEXEL(x, y) energy_texel(x, y)
#include "leadr/materials/energy.glsl"

#endif
