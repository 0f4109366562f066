// Features of a technique that the passes depend on. crates/leadr-render/src/settings/technique.rs sets these constants, and no shader
// depends on the technique itself.
#ifndef LEADR_TECHNIQUE
#define LEADR_TECHNIQUE

#include "leadr/slopes/packing.glsl"

layout(constant_id = 0) const int FAMILY = 4; // function that shades pixels: a FAMILY_ constant of shade/families.glsl

layout(constant_id = 20) const bool USES_SLOPES = true;
layout(constant_id = 21) const bool USES_COVARIANCE = true;
layout(constant_id = 22) const bool ISOTROPIC_COVARIANCE = false; // all directions have the same variance
layout(constant_id = 29) const bool LARGEST_VARIANCE = false;     // that variance is the largest along any direction, not the mean
layout(constant_id = 23) const bool FINEST_LEVEL = false;         // only the finest maps are used, since many samples per pixel filter them
layout(constant_id = 24) const bool GGX_BASE = false;             // the base material is GGX, not Beckmann
layout(constant_id = 35) const bool PHONG_FACETS = false;         // base and relief have Phong's distribution of normals (leadr/integrals/phong.glsl)
layout(constant_id = 25) const bool USES_CURVATURE = true;        // rotation of the macrosurface under a pixel adds roughness
layout(constant_id = 32) const bool PER_LIGHT_KERNEL = false;     // lights have kernels of their own (shade/pixel_kernel.glsl)
layout(constant_id = 26) const bool TILTS_TO_EDGE = true;         // mean slopes that face away are tilted to edge-on
layout(constant_id = 27) const bool USES_HORIZON = false;         // bumps occlude each other's surroundings
layout(constant_id = 28) const bool DETAIL_IN_GLOSS = false;      // a detail roughens the material instead of spreading the slopes

// Returns the covariance that the technique shades with. S is the total covariance under a pixel. in_no_map is the part of S that comes
// from no map. Every technique treats this part as roughness.
vec3 technique_covariance(const vec3 S, const vec3 in_no_map) {
    vec3 kept = USES_COVARIANCE ? S : in_no_map;
    float variance = LARGEST_VARIANCE ? principal_variances(kept).x : 0.5 * (kept.x + kept.y);
    return ISOTROPIC_COVARIANCE ? vec3(vec2(variance), 0.0) : kept;
}

#endif
