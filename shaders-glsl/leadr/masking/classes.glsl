#ifndef LEADR_CLASS_MASKING_GLSL
#define LEADR_CLASS_MASKING_GLSL

#include "correlated.glsl"

// Computes masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms, from the measured openness of a
// class: the visible part of its projected area (crates/leadr-reflectance/src/masking/classes.rs).

// Returns the openness for a footprint that contains the fraction `inside` of the relief. The rest hides nothing here, because it is
// larger than the footprint (leadr/visible/horizon.glsl).
float openness_inside(const float open, const float inside) {
    return open / max(open + inside * (1.0 - open), 1e-6);
}

// Returns the fraction of the facets of a class that are lit, among those that are visible. seen and lit are the openness towards viewer and
// light, and po and pi are both directions in the space where the relief is isotropic. The directions are independent if their azimuths are
// far apart. For equal azimuths, one direction hides all that the other one hides.
float class_lit_fraction(const int shadowing, const float seen, const float lit, const vec2 po, const vec2 pi) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return 1.0;
    float f = 1.0;
    if (shadowing != LEADR_SHADOWING_SMITH) {
        float o = 1.0 / max(seen, 1e-3) - 1.0, i = 1.0 / max(lit, 1e-3) - 1.0;
        f = decorrelation(po, pi, 1.0, max(o, i), min(o, i), shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    }
    return mix(min(lit / max(seen, 1e-3), 1.0), lit, f);
}

#endif
