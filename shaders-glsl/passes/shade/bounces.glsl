// Light that the facets of a base reflect more than once (MULTISCATTERING), both specular light and light from the diffuse base below.
#ifndef LEADR_SHADE_BOUNCES
#define LEADR_SHADE_BOUNCES
#include "energy.glsl"
#include "surface.glsl"
#include "leadr/materials/multiscattering.glsl"
#include "leadr/slopes/grid.glsl"

struct Bounces {
    vec3 specular;       // factor on the single-bounce specular reflection (Turquin 2019)
    Frame about;         // frame about the mean normal, in the tangent frame
    vec3 wo;             // direction toward the viewer, in the frame `about`
    float alpha;
    FacetBounces facets;
    vec3 entered;        // fraction of light that enters along wo
    vec3 average;        // fraction of light that enters, averaged over the hemisphere
};

// Computes the bounces for a base of roughness alpha. Bounces within the relief are excluded, because more of the roughness becomes visible
// relief as the viewer approaches.
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

// Returns the diffuse light from wi (tangent frame), divided by that of a Lambertian surface with the same entering light. The albedo is that
// of the surface, so the mean over all directions is 1.
vec3 bounced_light(const Bounces b, const Surface surface, const vec3 albedo, const vec3 wi) {
    vec3 towards = to_frame(b.about, wi);
    towards.z = max(towards.z, 1e-3);
    vec3 entered_i = entered(surface.diffuse_f0, energy_albedo(b.alpha, towards.z), energy_average(b.alpha).x);
    vec3 facets = facet_albedo(b.facets, albedo);
    vec3 value = multiscattering_diffuse(b.wo, towards, b.facets, surface.diffuse_f0, facets, b.entered, entered_i, b.average);
    return value * LEADR_PI / max(albedo * b.entered, 1e-4);
}

#endif
