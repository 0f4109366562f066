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

// Returns the openness for such a footprint.
float openness_inside(const float open, const float inside) {
    return max(open / max(open + inside * (1.0 - open), 1e-12), 1.0 / (1.0 + LEADR_MOST_DEPTH));
}

// Returns the openness of the classes in a footprint, whose facets can be more or less open than the mean facet of their class. open is that
// of the mean, components are those of the local openness in the direction, and amounts are their amounts in the footprint
// (crates/leadr-maps/src/derive/local_openness.rs).
vec4 local_openness(const vec4 open, const vec4 components, const vec4 amounts) {
    return clamp(open + dot(components, amounts), 0.0, 1.0);
}

// Returns the angle between the azimuths of two directions of a plane. x: the tangent of half the angle; y: the cosine where the angle is
// more than a quarter turn, with the opposite sign, and 0 otherwise.
vec2 azimuths_apart(const vec2 a, const vec2 b) {
    float scale = inversesqrt(max(dot(a, a) * dot(b, b), 1e-36));
    float cosine = dot(a, b) * scale;
    float sine = abs(cross_product(a, b)) * scale;
    float half_tangent = (cosine >= 0.0 ? sine : 1.0 - cosine) / max(cosine >= 0.0 ? 1.0 + cosine : sine, 1e-6);
    return vec2(half_tangent, max(-cosine, 0.0));
}

// Returns the fraction of the facets of a class that is lit, among those that are visible. o and i are the optical depths towards viewer and
// light, and apart is the result of azimuths_apart. The correlation has three numbers. x: the half tangent at which the directions are half
// as independent as those of azimuths far apart. y, for azimuths up to a quarter turn apart: 1 for facets that are open to both directions
// by their height, as in Smith's form, 0 for independent directions, and negative for facets that each direction hides from a different
// side. z: the same for opposite azimuths.
float class_lit_fraction(const vec2 apart, const vec3 correlation, const float o, const float i) {
    float more = max(o, i);
    float less = min(o, i);
    float width = apart.x + correlation.x;
    float dependent = mix(correlation.y, correlation.z, apart.y);
    return (1.0 + o) * width / ((1.0 + more) * width + apart.x * less * (1.0 + (1.0 - dependent) * more));
}

// Returns azimuths_apart for a model of shadowing. po and pi are both directions in the space where the relief is isotropic.
vec2 azimuths_apart(const int shadowing, const vec2 po, const vec2 pi) {
    vec2 apart = azimuths_apart(po, pi);
    return shadowing == LEADR_SHADOWING_SMITH ? vec2(1e6, apart.y) : apart;
}

// Returns class_lit_fraction for a model of shadowing.
float class_lit_fraction(const int shadowing, const vec2 apart, const vec3 correlation, const float o, const float i) {
    if (shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP) return 1.0;
    return class_lit_fraction(apart, correlation, o, i);
}

#endif
