// The base below a specular coat, by the model of its diffuse reflection (DIFFUSE_MODEL). MULTISCATTERING adds the light that facets
// reflect more than once, both specular light and light from the diffuse base.
#ifndef LEADR_SHADE_BOUNCES
#define LEADR_SHADE_BOUNCES
#include "energy.glsl"
#include "settings.glsl"
#include "surface.glsl"
#include "leadr/materials/diffuse_models.glsl"
#include "leadr/slopes/grid.glsl"

struct Bounces {
    vec3 specular;       // factor on the single-bounce specular reflection (Turquin 2019)
    Frame about;         // frame about the facet that stands for all visible facets, in the tangent frame
    vec3 wo;             // direction toward the viewer, in the frame `about`
    float alpha;
    FacetBounces facets;
    vec3 entered;        // fraction of light that enters along wo
    vec3 average;        // fraction of light that enters, averaged over the hemisphere
    vec3 albedo;         // reflected fraction of even light that enters, relative to Lambert's law
};

// Computes the bounces for a base of roughness alpha on a facet with this slope. Bounces within the relief are excluded, because more of the
// roughness becomes visible relief as the viewer approaches.
Bounces bounces_of(const Surface surface, const vec2 slope, float alpha) {
    Bounces b;
    b.about = frame_about(normal_of_slope(slope));
    b.wo = to_frame(b.about, surface.wo);
    b.wo.z = max(b.wo.z, 1e-3);
    b.alpha = alpha;
    b.facets = facet_bounces(alpha);
    vec2 albedo = energy_albedo(alpha, b.wo.z), average = energy_average(alpha);
    b.specular = MULTISCATTERING ? compensation_scale(surface.f0, albedo.x) : vec3(1.0);
    b.entered = entered(surface.diffuse_f0, albedo, average.x);
    b.average = entered(surface.diffuse_f0, average, average.x);
    b.albedo = diffuse_model_albedo(DIFFUSE_MODEL, b.wo.z, alpha, surface.albedo);
    return b;
}

// Returns the diffuse light from wi (tangent frame), divided by that of a Lambertian surface with the same albedo toward the viewer. The mean
// over all directions is 1.
vec3 bounced_light(const Bounces b, const Surface surface, const vec3 albedo, const vec3 wi) {
    vec3 towards = to_frame(b.about, wi);
    towards.z = max(towards.z, 1e-3);
    if (!MULTISCATTERING) {
        return diffuse_value(DIFFUSE_MODEL, b.wo, towards, b.alpha, albedo) / max(b.albedo, 1e-4);
    }
    vec3 entered_i = entered(surface.diffuse_f0, energy_albedo(b.alpha, towards.z), energy_average(b.alpha).x);
    vec3 facets = facet_albedo(b.facets, albedo);
    vec3 value = multiscattering_diffuse(b.wo, towards, b.facets, surface.diffuse_f0, facets, b.entered, entered_i, b.average);
    return value * LEADR_PI / max(albedo * b.entered, 1e-4);
}

#endif
