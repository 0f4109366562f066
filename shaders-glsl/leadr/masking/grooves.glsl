#ifndef LEADR_GROOVES_GLSL
#define LEADR_GROOVES_GLSL

#include "../constants.glsl"

// Symmetric V-grooves, which hide a part of each facet (Torrance and Sparrow 1967; thesis Table 2.IV).
// crates/leadr-reflectance/src/masking/grooves.rs gives the derivation.

// The smallest projected area of the mesosurface. Below it, facets would appear at once instead of gradually, which 32 bits cannot resolve.
const float LEADR_LEAST_GROOVE_AREA = 1e-3;

// Returns the visible area of a facet. facet and meso are the projected areas of the facet and of the mesosurface.
float groove_visible_area(const float facet, const float meso) {
    return min(max(facet, 0.0), 2.0 * max(meso, LEADR_LEAST_GROOVE_AREA));
}

// Returns the fraction of the visible part of a facet that is lit, 0..1. facet_o and facet_i are the projected areas of the facet towards
// viewer and light, and meso_o and meso_i those of the mesosurface.
float groove_lit_fraction(const float facet_o, const float facet_i, const float meso_o, const float meso_i) {
    float seen = groove_visible_area(facet_o, meso_o);
    float lit = 2.0 * max(meso_i, 0.0) * max(facet_o, 0.0);
    return min(lit / max(max(facet_i, 0.0) * seen, 1e-30), 1.0);
}

// Returns G / a_o = min(f, 2 a_o, 2 a_i) / (f a_o) of the facet that reflects the light. At a_o = 0 it is the limit, 2/f. ao and ai are at
// least 0.
float groove_factor(const float facet, const float ao, const float ai) {
    return ai / max(max(ai * max(max(ao, 0.5 * facet), LEADR_MIN_AREA), 0.5 * facet * ao), 1e-30);
}

#endif
