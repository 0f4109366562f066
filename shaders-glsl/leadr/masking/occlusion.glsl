#ifndef LEADR_OCCLUSION_GLSL
#define LEADR_OCCLUSION_GLSL

#include "../constants.glsl"

// Occlusion of a point by surrounding geometry, as one number or as a cone (Chan 2018, 4.4-4.7;
// crates/leadr-reflectance/src/masking/occlusion.rs). The visibility is the unoccluded fraction of the cosine-weighted hemisphere. A cone
// is vec4(axis, cosine of its half angle), and contains unoccluded directions only.

// Assumptions of adjusted_visibility about the radiance of occluded directions.
const int LEADR_HIDDEN_BLACK = 0;           // eq. 45
const int LEADR_HIDDEN_WHITE_OCCLUDED = 1;  // eq. 46
const int LEADR_HIDDEN_SAME_UNOCCLUDED = 2; // eq. 47
const int LEADR_HIDDEN_SAME_OCCLUDED = 3;   // eq. 48
const int LEADR_HIDDEN_SAME_RADIANCE = 4;   // eq. 49: all bounces

// Returns A / (1 - rho (1 - A)), eq. 49, or 0 for A = 0.
vec3 interreflected_visibility(const float visibility, const vec3 albedo) {
    float a = clamp(visibility, 0.0, 1.0);
    vec3 rho = clamp(albedo, 0.0, 1.0);
    return a / max((1.0 - rho) + rho * a, vec3(1e-12));
}

// Returns the fraction of a white environment that reaches a point of this visibility and albedo. `hidden` selects the assumption about the
// radiance of occluded directions.
vec3 adjusted_visibility(const int hidden, const float visibility, const vec3 albedo) {
    float a = clamp(visibility, 0.0, 1.0);
    vec3 rho = clamp(albedo, 0.0, 1.0);
    if (hidden == LEADR_HIDDEN_BLACK) return vec3(a);
    if (hidden == LEADR_HIDDEN_WHITE_OCCLUDED) return vec3(a + a * (1.0 - a));
    if (hidden == LEADR_HIDDEN_SAME_UNOCCLUDED) return a + rho * (1.0 - a);
    if (hidden == LEADR_HIDDEN_SAME_OCCLUDED) return a + rho * (a * (1.0 - a));
    return interreflected_visibility(a, rho);
}

// Returns the cosine of the half angle of the cone about the normal that has this visibility, sqrt(1 - V) (eq. 56).
float cone_cosine(const float visibility) {
    return sqrt(1.0 - clamp(visibility, 0.0, 1.0));
}

// Returns the visibility of a cone about the normal, 1 - cos^2 (eq. 55).
float cone_visibility(const float cosine) {
    float c = clamp(cosine, 0.0, 1.0);
    return (1.0 - c) * (1.0 + c);
}

// Returns sqrt(1 - x^2).
float cone_root(const float x) {
    return sqrt(max((1.0 - x) * (1.0 + x), 0.0));
}

// Returns the visibility of a cone about any axis, excluding its part below the horizon. The result is the projected area of a disc or, if
// the horizon clips the cone, the form factor of a clipped sphere (Snyder 1996).
float bent_cone_visibility(const vec4 cone) {
    float cosine = clamp(cone.w, 0.0, 1.0), z = clamp(cone.z, -1.0, 1.0);
    float sine = cone_root(cosine), tilt = cone_root(z);
    if (z >= sine) return sine * sine * z;
    if (-z >= sine || sine < 1e-6) return 0.0;
    float cut = clamp(-cosine * z / max(sine * tilt, 1e-12), -1.0, 1.0);
    float across = cone_root(cut);
    // The arguments lie on the unit circle, so atan can replace acos, which loses precision near 1.
    float disc = sine * (sine * z * atan(across, cut) - cosine * tilt * across);
    float edge = sine * tilt * across;
    return clamp((disc + atan(edge, max(cosine, 1e-30))) / LEADR_PI, 0.0, 1.0);
}

// Returns the cosine of the half angle of the cone about `axis` that has this visibility. The function inverts bent_cone_visibility. The
// result is exact for cones above the horizon. For a cone that crosses the horizon, the error is within 1.3 degrees if the axis is at most
// 75 degrees from the normal.
float bent_cone_cosine(const float visibility, const vec3 axis) {
    float v = clamp(visibility, 0.0, 1.0), z = clamp(axis.z, -1.0, 1.0);
    if (z <= 1e-6) return 1.0;
    float tilt = cone_root(z);
    float touching = z * z * z, widest = 0.5 + 0.5 * z;
    if (v <= touching) return cone_cosine(v / z);
    float width = widest - touching;
    float t = min((v - touching) / max(width, 1e-9), 1.0), s = 1.0 - t;
    float steep = -width / max(2.0 * tilt * z, 1e-9);
    float last = -width * LEADR_PI / max(2.0 * tilt, 1e-9);
    return clamp(s * s * ((1.0 + 2.0 * t) * tilt + t * steep) - t * t * s * last, 0.0, 1.0);
}

// Returns the cone of a visibility vector, the sum of the unoccluded directions over pi. The direction of the vector is the axis of the
// cone, and its length is the visibility. A zero vector gives an empty cone about z.
vec4 cone_of_vector(const vec3 b) {
    float share = length(b);
    return share > 1e-12 ? vec4(b / share, cone_cosine(share)) : vec4(0.0, 0.0, 1.0, 1.0);
}

// Returns the cone that has this visibility about a bent normal.
vec4 bent_cone(const float visibility, const vec3 axis) {
    return vec4(axis, bent_cone_cosine(visibility, axis));
}

// Returns 1 for a light whose direction wi is within the cone, otherwise 0 (eq. 57).
float cone_light(const vec4 cone, const vec3 wi) {
    return dot(cone.xyz, wi) > cone.w ? 1.0 : 0.0;
}

// Returns the visibility of a light from wi, which falls off outside the cone as clamp(axis.wi / cos, 0, 1)^2 (eq. 58).
float cone_light_smooth(const vec4 cone, const vec3 wi) {
    float along = dot(cone.xyz, wi);
    float ratio = along >= cone.w ? 1.0 : clamp(along / max(cone.w, 1e-12), 0.0, 1.0);
    return ratio * ratio;
}

// How a light fades outside a cone.
const int LEADR_CONE_EDGE_SOFT = 0;   // eq. 58
const int LEADR_CONE_EDGE_LINEAR = 1; // figure 18
const int LEADR_CONE_EDGE_HARD = 2;   // eq. 57
const int LEADR_CONE_EDGE_OPEN = 3;

// The axis of the cone that shadows suns and lamps.
const int LEADR_CONE_AXIS_BENT = 0;   // the direction of what is visible
const int LEADR_CONE_AXIS_NORMAL = 1; // the normal (eq. 57 and 58)

// Returns the fraction of the light from wi that a cone lets through. edge is a LEADR_CONE_EDGE_ constant.
float cone_light_by_edge(const int edge, const vec4 cone, const vec3 wi) {
    if (edge == LEADR_CONE_EDGE_OPEN) return 1.0;
    if (edge == LEADR_CONE_EDGE_HARD) return cone_light(cone, wi);
    float soft = cone_light_smooth(cone, wi);
    return edge == LEADR_CONE_EDGE_LINEAR ? sqrt(soft) : soft;
}

// Returns the cosine of a cone about the normal, widened for smooth surfaces and grazing viewers (listing 3). Without `biased`, eq. 60 is
// left out. exponent is the exponent of the gloss: 6 in the listing, 8 in the text.
float adjusted_cone_cosine(const float cosine, const float gloss, const float n_v, const bool biased, const int exponent) {
    float g = clamp(biased ? 1.5 * gloss : gloss, 0.0, 1.0);
    float g2 = g * g;
    float g6 = g2 * g2 * g2;
    float k = 1.0 - clamp(n_v, 0.0, 1.0);
    return clamp(cosine, 0.0, 1.0) * (1.0 - (exponent == 6 ? g6 : g6 * g2)) * (1.0 - k * k * k * k);
}

// The cone that hides the specular reflection of the environment.
const int LEADR_CONE_LOBE_BENT = 0;     // the cone itself
const int LEADR_CONE_LOBE_NORMAL = 1;   // a cone of the same visibility about the normal
const int LEADR_CONE_LOBE_ADJUSTED = 2; // this cone, widened by eq. 59
const int LEADR_CONE_LOBE_BIASED = 3;   // this cone, widened by eq. 60 and listing 3

// Returns the cone that hides the specular reflection of a point with this visibility and cone. gloss is on Chan's scale, and n_v is the
// viewer's cosine to the normal.
vec4 cone_of_lobe(const int lobe, const vec4 cone, const float visibility, const float gloss, const float n_v) {
    if (lobe == LEADR_CONE_LOBE_BENT) return cone;
    float cosine = cone_cosine(visibility);
    if (lobe == LEADR_CONE_LOBE_ADJUSTED) cosine = adjusted_cone_cosine(cosine, gloss, n_v, false, 8);
    if (lobe == LEADR_CONE_LOBE_BIASED) cosine = adjusted_cone_cosine(cosine, gloss, n_v, true, 6);
    return vec4(0.0, 0.0, 1.0, cosine);
}

#endif
