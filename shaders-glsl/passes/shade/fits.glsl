// The measured materials of a scene, the harmonics of its environment and the tables of energies, all in one buffer.
#ifndef LEADR_SHADE_FITS
#define LEADR_SHADE_FITS
#include "../constants.glsl"
#include "../bases.glsl"
#include "../technique.glsl"

// Passes that filter and shade read all the 32 resources that drivers push, so these share one: nine coefficients of four numbers; the
// tables of leadr/materials/energy.glsl of GGX and of Beckmann facets; the visibility of the sky past large shapes (sky_visibility.glsl); where each material begins, counted from there; then one material
// after another (crates/leadr-render/src/surfaces/fits.rs).
layout(std430) readonly buffer Irradiance { float light_words[]; };
const uint ENERGY_WORDS = 36u;
const uint ENERGY_TABLE = 33u * 48u * 2u;
const uint SKY_WORDS = ENERGY_WORDS + 2u * ENERGY_TABLE;
const uint FIT_WORDS = SKY_WORDS + SKY_HEADER + SKY_NODES;
#define LEADR_FITTED_WORD(i) light_words[FIT_WORDS + i]
#include "leadr/materials/fitted.glsl"

vec2 energy_texel(int x, int y) {
    uint at = ENERGY_WORDS + (GGX_BASE ? 0u : ENERGY_TABLE) + 2u * uint(33 * y + x);
    return vec2(light_words[at], light_words[at + 1u]);
}
#define LEADR_ENERGY_TEXEL(x, y) energy_texel(x, y)
#include "leadr/materials/energy.glsl"

// Colours keep a roughness in 8 bits and in halves: what is nearer to 1 is the measured material itself.
const float SAME_STRETCH = 4e-3;

// Where the fit of this number begins, from 1.
uint fit_at(uint number) {
    return uint(light_words[FIT_WORDS + number - 1u]);
}

// How much steeper the slopes of a surface of roughness alpha are than those that were measured.
float fit_stretch(uint fit, float alpha) {
    float stretch = max(alpha, 1e-4) / fitted_alpha(fit);
    return abs(stretch - 1.0) < SAME_STRETCH ? 1.0 : stretch;
}

// Radiance coefficients of the environment, world space.
vec3[9] environment_sh() {
    vec3 c[9];
    for (int i = 0; i < 9; ++i) {
        c[i] = vec3(light_words[4 * i], light_words[4 * i + 1], light_words[4 * i + 2]);
    }
    return c;
}

#endif
