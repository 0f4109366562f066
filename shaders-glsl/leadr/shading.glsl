#ifndef LEADR_SHADING_GLSL
#define LEADR_SHADING_GLSL

#include "facets/base_roughness.glsl"
#include "integrals/facet_specular.glsl"
#include "visible/diffuse.glsl"
#include "visible/fresnel.glsl"

// The recommended diffuse and specular shading under a light (crates/leadr-reflectance/src/shading.rs). An environment needs texture
// lookups between the calls, so this file leaves it out. For the specular term of an environment, use visible/shadowed_specular.glsl. For
// the diffuse term, multiply the result of visible/shadowed_environment.glsl by the albedo and by one minus the mean Fresnel term.

// A displaced surface under one pixel, in the tangent frame.
struct LeadrSurface {
    vec2 mean_slope;
    vec3 slope_covariance; // covariance (xx, yy, xy) of the relief's slopes, without the base
    float roughness;       // Beckmann alpha of the base material
    vec3 albedo;           // albedo for the light that enters the surface
    vec3 f0;               // reflectance at normal incidence
};

// Returns the radiance towards wo under one light from wi, per unit of irradiance on a plane that faces the light. wo and wi
// are unit directions in the tangent frame.
vec3 leadr_light(const LeadrSurface surface, const vec3 wo, const vec3 wi) {
    vec2 m = surface.mean_slope;
    vec3 relief = clamp_covariance(surface.slope_covariance);
    vec3 cholesky = slope_cholesky(relief);
    DirectionArea o = direction_area(wo, m, cholesky);
    DirectionArea i = direction_area(wi, m, cholesky);
    float diffuse = lit_fraction(LEADR_SHADOWING_CORRELATED, o, i) * leadr_diffuse_light_visible(wo, wi, m, relief, false, 2);
    FacetSpecular f = facet_specular(wo, wi, surface.roughness, 0.0);
    vec3 specular = facet_specular_light(LEADR_SHADOWING_CORRELATED, o, i, f, m, cholesky, surface.f0);
    vec3 specular_s = add_facet_roughness(relief, surface.roughness, wo, m);
    return surface.albedo * (1.0 - visible_fresnel(wo, m, specular_s, surface.f0)) * diffuse + specular;
}

#endif
