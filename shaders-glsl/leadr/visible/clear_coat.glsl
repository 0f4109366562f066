#ifndef LEADR_CLEAR_COAT_GLSL
#define LEADR_CLEAR_COAT_GLSL

#include "../facets/fresnel.glsl"
#include "fresnel.glsl"
#include "slopes.glsl"

// Computes the energy of a clear coat over a base material. The coat adds its own specular lobe, and the base is multiplied by coated_base.
// All reflectances are means over the visible facets. crates/leadr-reflectance/src/visible/clear_coat.rs has the derivation.

// The reflectance of the coat at normal incidence, for an index of refraction of 1.5.
const float LEADR_COAT_F0 = 0.04;

// The index of refraction of the coat.
const ComplexIndex LEADR_COAT_INDEX = ComplexIndex(vec3(1.5), vec3(0.0));

// Returns the reflectance of the coat toward w. m and S are the slopes of the coat, including its roughness. weight is the covered fraction.
// `exact` is whether the Fresnel term is exact, otherwise Schlick's.
float coat_reflectance(const vec3 w, const vec2 m, const vec3 S, const float weight, const bool exact) {
    vec3 f0 = vec3(LEADR_COAT_F0);
    return weight * (exact ? visible_fresnel_exact(w, m, S, f0, LEADR_COAT_INDEX) : visible_fresnel(w, m, S, f0)).x;
}

// Returns the reflectance of one facet of the coat, seen at this cosine.
float coat_facet_reflectance(const float cosine, const float weight, const bool exact) {
    return weight * (exact ? fresnel_dielectric(max(cosine, 0.0), 1.5) : fresnel_schlick(vec3(LEADR_COAT_F0), cosine).x);
}

// Returns the reflectance of the coat for the spherical harmonics of orders 0, 1 and 2 of an environment.
vec3 coat_bands(const float weight, const bool exact) {
    vec3 schlick = LEADR_COAT_F0 + (1.0 - LEADR_COAT_F0) * vec3(1.0 / 21.0, 1.0 / 56.0, -1.0 / 14.0);
    return weight * (exact ? vec3(0.0917780, 0.0630481, -0.0262027) : schlick);
}

// Returns the mean reflectance of the coat for diffuse light.
float coat_average(const float weight, const bool exact) {
    return coat_bands(weight, exact).x;
}

// Returns the reflectances of the coat toward wo and wi, over the facets that are visible from both.
vec2 coat_reflectances(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const float weight, const bool exact) {
    VisibleSlopes from_viewer = visible_slopes(wo, m, S), from_light = visible_slopes(wi, m, S);
    return vec2(coat_reflectance(wo, from_light.mean, from_light.cov, weight, exact),
                coat_reflectance(wi, from_viewer.mean, from_viewer.cov, weight, exact));
}

// Returns the factor of the coat on the light that the base reflects. outward and inward are the reflectances of the coat toward the viewer
// and toward the light. below is its reflectance for light from the base, whose reflectance is `base`.
vec3 coated_base(const float outward, const float inward, const float below, const vec3 base) {
    return (1.0 - outward) * (1.0 - inward) / max(1.0 - below * base, vec3(1e-4));
}

#endif
