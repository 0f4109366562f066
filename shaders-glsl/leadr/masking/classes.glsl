#ifndef LEADR_CLASS_MASKING_GLSL
#define LEADR_CLASS_MASKING_GLSL

#include "correlated.glsl"

// Computes masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms, from the measured openness of each
// class (crates/leadr-reflectance/src/masking/classes.rs).

const float LEADR_MOST_DEPTH = 999.0; // the largest optical depth, where one facet in a thousand is open

// Returns the optical depth 1 / open - 1 for a footprint that contains the fraction `inside` of the relief. The rest hides nothing here,
// because it is larger than the footprint (leadr/visible/horizon.glsl).
float depth_inside(const float open, const float inside) {
    return min(inside * (1.0 - open) / max(open, 1e-12), LEADR_MOST_DEPTH);
}

// Returns the fraction of the facets of a class that is lit, among those that are visible. o and i are the optical depths towards viewer
// and light. f.x / (f.x + f.y) is the result of `decorrelation`: 0 where one direction hides all that the other one hides, and 1 for
// azimuths that are far apart. There, correlation is 1 for facets that are open to both by their height, as in Smith's form, 0 for
// independent directions, and negative for facets that each direction hides from a different side.
float class_lit_fraction(const vec2 f, const float correlation, const float o, const float i) {
    float more = max(o, i);
    float less = min(o, i);
    float all = f.x + f.y;
    return (1.0 + o) * all / ((1.0 + more) * all + f.x * less * (1.0 + (1.0 - correlation) * more));
}

// Returns the same for a model of shadowing. po and pi are both directions in the space where the relief is isotropic.
float class_lit_fraction(const int shadowing, const float correlation, const float o, const float i, const vec2 po, const vec2 pi) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return 1.0;
    vec2 f = vec2(1.0, 0.0);
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation_quotient(po, pi, 1.0, max(o, i), min(o, i), shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    return class_lit_fraction(f, correlation, o, i);
}

#endif
