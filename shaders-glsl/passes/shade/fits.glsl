// The measured materials of a scene.
#ifndef LEADR_SHADE_FITS
#define LEADR_SHADE_FITS

// The start of each material, relative to this array, followed by the materials (crates/leadr-render/src/surfaces/fits.rs).
layout(set = 1, std430) readonly buffer Fits { float fit_words[]; };
#define LEADR_FITTED_WORD(i) fit_words[i]
#include "leadr/materials/fitted.glsl"

// The roughness is stored with colours, in 8 bits and in halves. A stretch this close to 1 means the measured material itself.
const float SAME_STRETCH = 4e-3;

// Returns the start of the fit with this number, counted from 1.
uint fit_at(const uint number) {
    return uint(fit_words[number - 1u]);
}

// Returns the ratio between the slopes of a surface of roughness alpha and the measured slopes.
float fit_stretch(const uint fit, const float alpha) {
    float stretch = max(alpha, 1e-4) / fitted_alpha(fit);
    return abs(stretch - 1.0) < SAME_STRETCH ? 1.0 : stretch;
}

#endif
