// Specialisation constants of the shading pipelines (src/render/passes/shade.rs).
#ifndef LEADR_SHADE_SETTINGS
#define LEADR_SHADE_SETTINGS
#include "../constants.glsl"
#include "../technique.glsl"
#include "leadr/masking/correlated.glsl"

layout(constant_id = 1) const bool VISIBLE_SLOPES = false; // the visible-slope rules instead of the paper's grid
layout(constant_id = 2) const int SAMPLES = 5;             // number of environment probes, or N of the N x N grid
layout(constant_id = 3) const int SHADOWING = LEADR_SHADOWING_SMITH;
layout(constant_id = 4) const bool LIGHTS_BY_SH = false;   // diffuse lights through order-2 SH as in Algorithm 2
layout(constant_id = 5) const int TERMS = 15;              // a bit per term of light transport
// Lights go from FIRST_LIGHT to POINT_LIGHTS; number 0 is the sun.
layout(constant_id = 6) const int FIRST_LIGHT = 0;
layout(constant_id = 7) const bool SUN_SHADOWS = true;     // cast by the macrosurface, from the shadow map
layout(constant_id = 8) const int POINT_LIGHTS = 0;        // at most MAX_POINT_LIGHTS
layout(constant_id = 9) const int EDGES = EDGES_ARE_ABSENT;

const bool SPECULAR_LIGHTS = (TERMS & TERM_SPECULAR_LIGHTS) != 0;
const bool DIFFUSE_LIGHTS = (TERMS & TERM_DIFFUSE_LIGHTS) != 0;
const bool SPECULAR_ENVIRONMENT = (TERMS & TERM_SPECULAR_ENVIRONMENT) != 0;
const bool DIFFUSE_ENVIRONMENT = (TERMS & TERM_DIFFUSE_ENVIRONMENT) != 0;
const bool LIGHTS = SPECULAR_LIGHTS || DIFFUSE_LIGHTS;
const bool DIFFUSE = DIFFUSE_LIGHTS || DIFFUSE_ENVIRONMENT;

#endif
