// What a shading pipeline is specialized for (src/render/passes/shade.rs).
#ifndef LEADR_SHADE_SETTINGS
#define LEADR_SHADE_SETTINGS
#include "../technique.glsl"
#include "leadr/masking/correlated.glsl"

layout(constant_id = 1) const bool VISIBLE_SLOPES = false; // the visible-slope rules, or the paper's grid
layout(constant_id = 2) const int SAMPLES = 5;             // environment probes; N of the N x N grid
layout(constant_id = 3) const int SHADOWING = LEADR_SHADOWING_SMITH;
layout(constant_id = 4) const bool LIGHTS_BY_SH = false;   // diffuse lights through order-2 SH as in Algorithm 2
layout(constant_id = 5) const int TERMS = 15;              // bits: which light counts
// Lights go from FIRST_LIGHT to POINT_LIGHTS; number 0 is the sun.
layout(constant_id = 6) const int FIRST_LIGHT = 0;
layout(constant_id = 7) const bool SUN_SHADOWS = true;     // of the macrosurface, by the shadow map
layout(constant_id = 8) const int POINT_LIGHTS = 0;        // at most MAX_POINT_LIGHTS
layout(constant_id = 9) const int EDGES = 0;               // how the EDGES_ samples come in

const int EDGES_ARE_SHADED = 1; // these are edge samples: what sees the pixel's own surface is left out
const int EDGES_ARE_JOINED = 2; // these are pixels whose edge samples were joined before

const bool SPECULAR_LIGHTS = (TERMS & 1) != 0;
const bool DIFFUSE_LIGHTS = (TERMS & 2) != 0;
const bool SPECULAR_ENVIRONMENT = (TERMS & 4) != 0;
const bool DIFFUSE_ENVIRONMENT = (TERMS & 8) != 0;
const bool LIGHTS = (TERMS & 3) != 0;
const bool DIFFUSE = (TERMS & 10) != 0;

#endif
