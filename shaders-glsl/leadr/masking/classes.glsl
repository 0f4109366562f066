#ifndef LEADR_CLASS_MASKING_GLSL
#define LEADR_CLASS_MASKING_GLSL

#include "correlated.glsl"

// Computes masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms, from the measured openness of each
// class (crates/leadr-reflectance/src/masking/classes.rs).

const float LEADR_MIN_OPEN = 1e-3; // the smallest openness that is used as a divisor

// Returns the openness for a footprint that contains the fraction `inside` of the relief. The rest hides nothing here, because it is
// larger than the footprint (leadr/visible/horizon.glsl).
float openness_inside(const float open, const float inside) {
    return open / max(open + inside * (1.0 - open), 1e-6);
}

// Returns the fraction of the facets of a class that is lit, among those that are visible. seen and lit are the openness towards viewer and
// light, and f is the result of `decorrelation`: 0 where one direction hides all that the other one hides, and 1 for azimuths that are far
// apart. There, correlation is 1 for facets that are open to both by their height, as in Smith's form, 0 for independent directions, and
// negative for facets that each direction hides from a different side.
float class_lit_fraction(const float f, const float correlation, const float seen, const float lit) {
    float o = 1.0 / max(seen, LEADR_MIN_OPEN) - 1.0;
    float i = 1.0 / max(lit, LEADR_MIN_OPEN) - 1.0;
    float more = max(o, i);
    float less = min(o, i);
    return (1.0 + o) / (1.0 + more + f * less * (1.0 + (1.0 - correlation) * more));
}

// Returns the same for a model of shadowing. po and pi are both directions in the space where the relief is isotropic.
float class_lit_fraction(const int shadowing, const float correlation, const float seen, const float lit, const vec2 po, const vec2 pi) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return 1.0;
    float o = 1.0 / max(seen, LEADR_MIN_OPEN) - 1.0;
    float i = 1.0 / max(lit, LEADR_MIN_OPEN) - 1.0;
    float f = 1.0;
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation(po, pi, 1.0, max(o, i), min(o, i), shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    return class_lit_fraction(f, correlation, seen, lit);
}

#endif
