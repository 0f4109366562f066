#ifndef LEADR_CLASS_MASKING_GLSL
#define LEADR_CLASS_MASKING_GLSL

#include "correlated.glsl"

// Computes masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms, from the measured openness of each
// class (crates/leadr-reflectance/src/masking/classes.rs).

// The openness of the classes towards a direction.
struct ClassesSeen {
    vec4 open;     // visible part of the projected area of each class, 0..1
    vec2 whitened; // the direction in the space where the relief is isotropic
    float lambda;  // Lambda of the whole relief
};

// Returns the openness for a footprint that contains the fraction `inside` of the relief. The rest hides nothing here, because it is
// larger than the footprint (leadr/visible/horizon.glsl).
vec4 openness_inside(const vec4 open, const float inside) {
    return open / (open + inside * (1.0 - open));
}

// Returns the mean Lambda of classes whose shares of the surface are given.
float classes_lambda(const vec4 open, const vec4 share) {
    return dot(share, 1.0 / max(open, 1e-3)) - 1.0;
}

// Returns the fraction of the facets of each class that are lit from i, among those that are visible from o. The directions are
// independent if their azimuths are far apart. For equal azimuths, one direction hides all that the other one hides.
vec4 class_lit_fractions(const int shadowing, const ClassesSeen o, const ClassesSeen i) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return vec4(1.0);
    float f = 1.0;
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation(o.whitened, i.whitened, 1.0, max(o.lambda, i.lambda), min(o.lambda, i.lambda),
                          shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    return mix(min(i.open / max(o.open, 1e-3), 1.0), i.open, f);
}

#endif
