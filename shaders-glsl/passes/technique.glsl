// What a technique needs from the passes: constants set by crates/leadr-render/src/settings/technique.rs. No shader knows which technique it
// draws.
#ifndef LEADR_TECHNIQUE
#define LEADR_TECHNIQUE

layout(constant_id = 0) const int FAMILY = 4; // which function shades pixels: a FAMILY_ constant of shade/families.glsl

layout(constant_id = 20) const bool USES_SLOPES = true;
layout(constant_id = 21) const bool USES_COVARIANCE = true;
layout(constant_id = 22) const bool ISOTROPIC_COVARIANCE = false; // one variance for all directions
layout(constant_id = 23) const bool FINEST_LEVEL = false;         // of the maps: samples per pixel do the filtering
layout(constant_id = 24) const bool GGX_BASE = false;             // the base material is GGX, not Beckmann
layout(constant_id = 25) const bool USES_CURVATURE = true;        // the turn of the macrosurface under a pixel counts as roughness
layout(constant_id = 26) const bool TILTS_TO_EDGE = true;         // mean slopes that face away from the viewer tilt until they are seen edge-on
layout(constant_id = 27) const bool USES_HORIZON = false;         // bumps hide the surroundings from each other
layout(constant_id = 28) const bool USES_RELIEF_COLOR = false;    // colours that follow the relief are those of what is seen and lit

// The covariance that the technique shades with. S: everything measured under a pixel; in_no_map: the part of it that comes from
// no map, which every technique treats as roughness.
vec3 technique_covariance(const vec3 S, const vec3 in_no_map) {
    vec3 kept = USES_COVARIANCE ? S : in_no_map;
    return ISOTROPIC_COVARIANCE ? vec3(vec2(0.5 * (kept.x + kept.y)), 0.0) : kept;
}

#endif
