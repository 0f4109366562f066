// Techniques, as src/render/settings.rs counts them.
#ifndef LEADR_TECHNIQUE
#define LEADR_TECHNIQUE

const int TECHNIQUE_CONSTANT = 0;
const int TECHNIQUE_BLINN_PHONG = 1;
const int TECHNIQUE_NORMAL_MIP = 2;
const int TECHNIQUE_TOKSVIG = 3;
const int TECHNIQUE_CLEAN = 4;
const int TECHNIQUE_LEAN = 5;
const int TECHNIQUE_LEADR = 6;
const int TECHNIQUE_LEADR_GGX = 7;
const int TECHNIQUE_REFERENCE = 8;

layout(constant_id = 0) const int TECHNIQUE = TECHNIQUE_LEADR;

// Finest level of the maps: supersampling does the filtering.
const bool FINEST_LEVEL = TECHNIQUE == TECHNIQUE_REFERENCE;
// Looks at mean slopes at all.
const bool USES_SLOPES = TECHNIQUE != TECHNIQUE_CONSTANT;
// Looks at the covariance of slopes.
const bool USES_COVARIANCE = TECHNIQUE > TECHNIQUE_NORMAL_MIP;
// Adds what the macrosurface itself turns under the pixel.
const bool USES_CURVATURE = (1 << TECHNIQUE & (1 << TECHNIQUE_LEADR | 1 << TECHNIQUE_LEADR_GGX)) != 0;

#endif
