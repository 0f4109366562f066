// The specialisation constants of the shading pipelines (crates/leadr-render/src/passes/shade.rs).
#ifndef LEADR_SHADE_SETTINGS
#define LEADR_SHADE_SETTINGS
#include "../constants.glsl"
#include "../bases.glsl"
#include "../technique.glsl"
#include "leadr/integrals/slope_nodes.glsl"
#include "leadr/integrals/specular.glsl"
#include "leadr/masking/correlated.glsl"
#include "leadr/masking/occlusion.glsl"
#include "leadr/materials/diffuse_models.glsl"

layout(constant_id = 1) const bool VISIBLE_SLOPES = false; // visible-slope rules replace the paper's grid
layout(constant_id = 2) const int SAMPLES = 5;             // number of environment probes, or N of the N x N grid
layout(constant_id = 30) const float GRID_LOD = LEADR_LOD_MATCHED; // constant of the level of detail at the nodes of the grid
layout(constant_id = 34) const int GRID_NODES = LEADR_NODES_GRID;   // a LEADR_NODES_ constant: the placement of the samples of the grid
layout(constant_id = 3) const int SHADOWING_MODEL = LEADR_SHADOWING_SMITH;
layout(constant_id = 4) const bool LIGHTS_BY_SH = false;   // diffuse lights use order-2 SH as in Algorithm 2
layout(constant_id = 5) const int TERMS = 15;              // a bit for each term of light transport
// The lights are in this order: the frame's own sun, the suns of its panorama, lamps.
layout(constant_id = 6) const int OWN_SUNS = 1;            // 0 or 1
layout(constant_id = 10) const int PANORAMA_SUNS = 0;      // at most MAX_ENVIRONMENT_LIGHTS
layout(constant_id = 7) const bool MAPPED_SHADOWS = true;  // shadows of the macrosurface come from the shadow maps
layout(constant_id = 8) const int LAMPS = 0;               // number of lamps that can have shadow maps, at most MAX_LAMP_MAPS
layout(constant_id = 19) const bool MORE_LAMPS = false;    // there are more lamps, without shadow maps
layout(constant_id = 31) const bool FACET_FRAME = false;  // base roughness is in the facets' frame, otherwise in the macrosurface's
layout(constant_id = 9) const int EDGES = EDGES_ARE_ABSENT;
layout(constant_id = 11) const int DIFFUSE_MODEL = LEADR_DIFFUSE_LAMBERT; // a LEADR_DIFFUSE_ constant
layout(constant_id = 12) const bool DRAWN_SPECULAR = false; // random visible specular directions, which differ between samples
layout(constant_id = 15) const bool INTERREFLECTION = false; // light between the facets of the relief (leadr/integrals/interreflection.glsl)
layout(constant_id = 16) const int CONE_OCCLUDERS = LEADR_HIDDEN_SAME_RADIANCE; // a LEADR_HIDDEN_ constant
layout(constant_id = 17) const int CONE_EDGE = LEADR_CONE_EDGE_SOFT;  // a LEADR_CONE_EDGE_ constant
layout(constant_id = 36) const int CONE_AXIS = LEADR_CONE_AXIS_BENT;  // a LEADR_CONE_AXIS_ constant
layout(constant_id = 18) const int CONE_LOBE = LEADR_CONE_LOBE_BENT;  // a LEADR_CONE_LOBE_ constant
layout(constant_id = 13) const bool SKY_OCCLUSION = false; // large shapes occlude the environment
layout(constant_id = 14) const bool TELLS_LIGHT = false;   // outputs the visibility of the lights instead of radiance

// Whether the material is a normal map on smooth geometry, whose relief does not occlude. In the reference, each sample hits one facet, and
// only the base causes masking.
const bool NORMAL_MAPPED = SHADOWING_MODEL == LEADR_SHADOWING_NORMAL_MAP;
const int SHADOWING = NORMAL_MAPPED && FINEST_LEVEL ? LEADR_SHADOWING_CORRELATED : SHADOWING_MODEL;
const bool MAPPED = NORMAL_MAPPED && !FINEST_LEVEL;
// Whether classes of facets hide each other. Their lit fractions then replace the shadowing within one Gaussian of slopes.
const bool BY_CLASS = CLASSES > 1 && CLASSES_HIDE && !MAPPED;
// Whether each facet is shadowed by itself. Relief and base then have one Gaussian of slopes, which is summed over a grid.
const bool V_GROOVES = SHADOWING_MODEL == LEADR_SHADOWING_VGROOVE;
const int FACET_SHADOWING = BY_CLASS ? LEADR_SHADOWING_NONE : SHADOWING;

const bool LAMBERTIAN = DIFFUSE_MODEL == LEADR_DIFFUSE_LAMBERT;
const bool MULTISCATTERING = DIFFUSE_MODEL == LEADR_DIFFUSE_MULTISCATTERING; // scales the specular term
const bool BLEND = DIFFUSE_MODEL == LEADR_DIFFUSE_BLEND; // scales the specular term
const bool CONSERVING = DIFFUSE_MODEL == LEADR_DIFFUSE_CONSERVING;
const bool SCALES_SPECULAR = MULTISCATTERING || BLEND;
// Whether the model replaces the light that the coat lets through.
const bool COAT_IN_MODEL = DIFFUSE_MODEL == LEADR_DIFFUSE_DISNEY || DIFFUSE_MODEL == LEADR_DIFFUSE_CALL_OF_DUTY || BLEND || CONSERVING;

const int DIFFUSE_TERMS = 2; // number of terms of the closed form (leadr/visible/diffuse.glsl)

const bool SPECULAR_LIGHTS = (TERMS & TERM_SPECULAR_LIGHTS) != 0;
const bool DIFFUSE_LIGHTS = (TERMS & TERM_DIFFUSE_LIGHTS) != 0;
const bool SPECULAR_ENVIRONMENT = (TERMS & TERM_SPECULAR_ENVIRONMENT) != 0;
const bool DIFFUSE_ENVIRONMENT = (TERMS & TERM_DIFFUSE_ENVIRONMENT) != 0;
const bool DIFFUSE = DIFFUSE_LIGHTS || DIFFUSE_ENVIRONMENT;
const int SUNS = OWN_SUNS + PANORAMA_SUNS;
const int LIGHTS = SUNS + LAMPS; // more lamps follow
const int ANY_LAMP = SUNS; // the number of a light that stands for any lamp, so that drivers can fold the conditions below
// Whether a light is a sun of the panorama. Suns of the panorama belong to the environment.
bool of_panorama(const int light) { return light >= OWN_SUNS && light < SUNS; }
bool on_diffuse(const int light) { return of_panorama(light) ? DIFFUSE_ENVIRONMENT : DIFFUSE_LIGHTS; }
bool in_specular(const int light) { return of_panorama(light) ? SPECULAR_ENVIRONMENT : SPECULAR_LIGHTS; }
bool any_on_diffuse() { return (DIFFUSE_LIGHTS && LIGHTS > PANORAMA_SUNS) || (DIFFUSE_ENVIRONMENT && PANORAMA_SUNS > 0); }
bool any_in_specular() { return (SPECULAR_LIGHTS && LIGHTS > PANORAMA_SUNS) || (SPECULAR_ENVIRONMENT && PANORAMA_SUNS > 0); }

#endif
