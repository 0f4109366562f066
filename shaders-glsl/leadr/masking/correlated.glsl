#ifndef LEADR_CORRELATED_MASKING_GLSL
#define LEADR_CORRELATED_MASKING_GLSL

#include "../facets/projected_area.glsl"
#include "../fma.glsl"
#include "smith.glsl"

// Computes masking and shadowing with the correlation between the directions of viewer and light:
//     G = 1 / (1 + max(Lambda_o, Lambda_i) + f min(Lambda_o, Lambda_i))
// The factor f is 0 for equal azimuths (in the space where the surface is isotropic) and rises to 1, Smith's form, for azimuths far apart.
// crates/leadr-reflectance/src/masking/correlated.rs derives the form. Once per pixel:
//     vec3 cholesky = slope_cholesky(S);
//     DirectionArea o = direction_area(wo, m, cholesky);
// and for each light:
//     float lit = lit_fraction(shadowing, o, direction_area(wi, m, cholesky));

// Shadowing models, which decide which of the visible facets are lit.
const int LEADR_SHADOWING_NONE = 0;              // all visible facets are lit, so only masking remains
const int LEADR_SHADOWING_SMITH = 1;             // LEADR eq. 13
const int LEADR_SHADOWING_CORRELATED = 2;        // the direction-correlated model
const int LEADR_SHADOWING_CORRELATED_SIMPLE = 3; // the simplified form of the direction-correlated model
const int LEADR_SHADOWING_NORMAL_MAP = 4;        // all facets facing the light are lit and count equally (visible/mapped.glsl)
const int LEADR_SHADOWING_SEPARABLE = 5;         // masking and shadowing are independent
const int LEADR_SHADOWING_VGROOVE = 6;           // each facet is shadowed by itself (grooves.glsl)

// The area of a surface that is visible from one direction.
struct DirectionArea {
    vec2 whitened; // p = C^T w.xy
    float spread;  // b = |p|
    float meso;    // a: projected area of the mesosurface
    float visible; // A: visible projected area
};

// Returns p = C^T w.xy from the lower Cholesky factor (c_xx, c_yx, c_yy) of the slopes' covariance.
vec2 whitened_direction(const vec3 w, const vec3 cholesky) {
    return vec2(cholesky.x * w.x + cholesky.y * w.y, cholesky.z * w.y);
}

DirectionArea direction_area(const vec3 w, const vec2 m, const vec3 cholesky) {
    vec2 whitened = whitened_direction(w, cholesky);
    float spread = length(whitened);
    float meso = meso_area(w, m);
    return DirectionArea(whitened, spread, meso, max(meso, 0.0) + rough_area(meso, spread));
}

// Returns the visible area along w for one shadowing model. Only the direction-correlated models need the whitened direction. The other
// models compute their areas from the covariance S, at lower cost.
DirectionArea area_for(const int shadowing, const vec3 w, const vec2 m, const vec3 S, const vec3 cholesky) {
    if (shadowing >= LEADR_SHADOWING_CORRELATED) return direction_area(w, m, cholesky);
    float spread = slope_spread(w, S);
    float meso = meso_area(w, m);
    return DirectionArea(vec2(0.0), spread, meso, max(meso, 0.0) + rough_area(meso, spread));
}

// Returns the 2D cross product a x b, which is exactly 0 for parallel vectors. Drivers may fuse one product with the difference, and the
// function corrects the rounding error.
float cross_product(const vec2 a, const vec2 b) {
    float product = a.y * b.x;
    return fma(a.x, b.y, -product) + fma(-a.y, b.x, product);
}

// Returns the factor f, from 0 for equal azimuths to 1. both is a_o a_i. less and more are a_o a_i times the smaller and the larger Lambda.
float decorrelation(const vec2 po, const vec2 pi, const float both, const float more, const float less, const bool simple) {
    float scale = inversesqrt(max(dot(po, po) * dot(pi, pi), 1e-36));
    float cosine = dot(po, pi) * scale;
    float sine = abs(cross_product(po, pi)) * scale;
    float along = cosine >= 0.0 ? 1.0 + cosine : sine * sine / (1.0 - cosine); // tan(phi/2) = sine / along
    if (simple) return (sine + 1e-9) / (sine + 0.26 * along + 1e-9);
    float late = 0.3 * (more - less) / max(more + less, 1e-30) * along;
    float t = sine * sine / max(sqrt(sine * sine + late * late) + late, 1e-18);
    float half_width = 0.5 * both / max(both + 2.0 * less, 1e-30) * along;
    return (t + 1e-9) / (t + half_width + 1e-9);
}

// Returns the factor f as x / (x + y). Callers merge the quotient into a division of their own. All arguments of `decorrelation` that are
// areas may have any common scale.
vec2 decorrelation_quotient(const vec2 po, const vec2 pi, const float both, const float more, const float less, const bool simple) {
    // The cosine, the sine and `along` of `decorrelation`, times scale.
    float scale = sqrt(max(dot(po, po) * dot(pi, pi), 1e-12));
    float cosine = dot(po, pi);
    float sine = abs(cross_product(po, pi));
    float over = cosine >= 0.0 ? scale + cosine : sine * sine, under = cosine >= 0.0 ? 1.0 : scale - cosine; // of `along`
    if (simple) return vec2((sine + 1e-9 * scale) * under, 0.26 * over);
    float sum = max(more + less, 1e-12);
    float along = over / (sum * under);
    float late = 0.3 * (more - less) * along;
    float t = max(sqrt(sine * sine + late * late) + late, 1e-9 * scale); // the result is multiplied by t and both + 2 less
    return vec2(max((sine * sine + 1e-9 * scale * t) * max(both + 2.0 * less, 1e-12), 1e-25), 0.5 * both * sum * along * t);
}

// Returns whether a model lights all facets, or shadows each facet by itself, so that no fraction of the visible area applies to all.
bool lights_all(const int shadowing) {
    return shadowing == LEADR_SHADOWING_NONE || shadowing == LEADR_SHADOWING_NORMAL_MAP || shadowing == LEADR_SHADOWING_VGROOVE;
}

// Returns G A_o / a_o, the lit fraction of the visible area, 0..1. The fraction weights a light, or a sample of an environment, in a sum
// that already includes masking.
float lit_fraction(const int shadowing, const DirectionArea o, const DirectionArea i) {
    if (lights_all(shadowing)) return 1.0;
    if (shadowing == LEADR_SHADOWING_SEPARABLE) return max(i.meso, 0.0) / max(i.visible, LEADR_MIN_AREA);
    float ao = max(o.meso, 0.0);
    float ai = max(i.meso, 0.0);
    float seen = ai * max(o.visible, LEADR_MIN_AREA);
    float hidden_o = max(o.visible - ao, 0.0) * ai;
    float hidden_i = max(i.visible - ai, 0.0) * ao;
    float more = max(hidden_o, hidden_i);
    float less = min(hidden_o, hidden_i);
    float f = 1.0;
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation(o.whitened, i.whitened, ao * ai, more, less, shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    return seen / max(seen + max(hidden_i - hidden_o, 0.0) + f * less, 1e-30);
}

// Returns lit_fraction of slopes with the same variance along all axes, with fewer divisions. ao and Ao are the projected area of the
// mesosurface, at least 0, and the visible area for the viewer.
float round_lit_fraction(const int shadowing, const vec3 wo, const float ao, const float Ao, const vec3 wi, const vec2 m, const float variance) {
    if (lights_all(shadowing)) return 1.0;
    float ai = max(meso_area(wi, m), 0.0);
    AreaQuotient i = visible_area_quotient(wi, m, vec3(vec2(variance), 0.0));
    if (shadowing == LEADR_SHADOWING_SEPARABLE) return ai * i.under / i.over;
    // All areas are multiplied by i.under.
    float seen = ai * i.under * max(Ao, LEADR_MIN_AREA);
    float hidden_o = max(Ao - ao, 0.0) * ai * i.under;
    float hidden_i = max(i.over - ai * i.under, 0.0) * ao;
    float less = min(hidden_o, hidden_i);
    vec2 f = vec2(1.0, 0.0);
    if (shadowing != LEADR_SHADOWING_SMITH)
        f = decorrelation_quotient(wo.xy, wi.xy, ao * ai * i.under, max(hidden_o, hidden_i), less, shadowing == LEADR_SHADOWING_CORRELATED_SIMPLE);
    float all = f.x + f.y;
    return seen * all / max((seen + max(hidden_i - hidden_o, 0.0)) * all + f.x * less, 1e-36);
}

// Returns G / a_o, within 0..1e6. The result is the factor of F D / 4 in f_r cos(theta_i). The factor is 1 for a normal map, whose facets
// count by their area on the macrosurface and have factors of their own.
float masking_shadowing_factor(const int shadowing, const DirectionArea o, const DirectionArea i) {
    if (shadowing == LEADR_SHADOWING_NORMAL_MAP) return 1.0;
    return lit_fraction(shadowing, o, i) / max(o.visible, LEADR_MIN_AREA);
}

#endif
