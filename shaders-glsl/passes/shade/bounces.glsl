// Light that facets of a base reflect more than once (MULTISCATTERING), specular and from the diffuse base below.
#ifndef LEADR_SHADE_BOUNCES
#define LEADR_SHADE_BOUNCES
#include "energy.glsl"
#include "surface.glsl"
#include "leadr/materials/multiscattering.glsl"
#include "leadr/slopes/grid.glsl"

struct Bounces {
    vec3 specular;       // factor on single-bounce reflection (Turquin 2019)
    Frame about;         // the mean normal, in the tangent frame
    vec3 wo;             // toward the viewer, in that frame
    float alpha;
    FacetBounces facets;
    vec3 entered;        // light that enters along wo
    vec3 average;        // light that enters, mean over the hemisphere
};

// alpha: of the base. The relief's own bounces are excluded: as the viewer approaches, roughness becomes resolved relief.
Bounces bounces_of(const Surface surface, float alpha) {
    Bounces b;
    vec3 n = normal_of_slope(surface.mean_slope);
    b.about = frame_about(n);
    b.wo = to_frame(b.about, surface.wo);
    b.wo.z = max(b.wo.z, 1e-3);
    b.alpha = alpha;
    b.facets = facet_bounces(alpha);
    vec2 albedo = energy_albedo(alpha, b.wo.z), average = energy_average(alpha);
    b.specular = compensation_scale(surface.f0, albedo.x);
    b.entered = entered(surface.diffuse_f0, albedo, average.x);
    b.average = entered(surface.diffuse_f0, average, average.x);
    return b;
}

// Diffuse light from wi (tangent frame) over that of a Lambertian surface with the same entering light.
vec3 bounced_light(const Bounces b, const Surface surface, const vec3 albedo, const vec3 wi) {
    vec3 towards = to_frame(b.about, wi);
    towards.z = max(towards.z, 1e-3);
    vec3 entered_i = entered(surface.diffuse_f0, energy_albedo(b.alpha, towards.z), energy_average(b.alpha).x);
    vec3 value = multiscattering_diffuse(b.wo, towards, b.facets, surface.diffuse_f0, albedo, b.entered, entered_i, b.average);
    return value * LEADR_PI / max(albedo * b.entered, 1e-4);
}

#endif
