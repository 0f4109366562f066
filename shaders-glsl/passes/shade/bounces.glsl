// The base below a specular coat, by the model of its diffuse reflection (DIFFUSE_MODEL). MULTISCATTERING adds the light that facets
// reflect more than once, both specular light and light from the diffuse base.
#ifndef LEADR_SHADE_BOUNCES
#define LEADR_SHADE_BOUNCES
#include "energy.glsl"
#include "settings.glsl"
#include "surface.glsl"
#include "leadr/materials/diffuse_models.glsl"
#include "leadr/slopes/grid.glsl"
#include "leadr/visible/fresnel.glsl"

struct Bounces {
    vec3 specular;       // factor on the single-bounce specular reflection (Turquin 2019; thesis eq. 5.4)
    Frame about;         // frame about the facet that stands for all visible facets, in the tangent frame
    vec3 wo;             // direction toward the viewer, in the frame `about`
    float alpha;
    FacetBounces facets;
    vec3 entered;        // fraction of light that enters along wo
    vec3 average;        // fraction of light that enters, averaged over the hemisphere
    vec3 albedo;         // reflected fraction of even light that enters, relative to Lambert's law
};

// Returns the mean deviation of the exact Fresnel term from Schlick's over the visible facets of a base of roughness alpha.
vec3 rough_deviation(const float alpha, const float cosine, const vec3 f0, const ComplexIndex index) {
    vec3 wo = vec3(sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0, cosine);
    return mean_deviation(visible_cosines(visible_slopes(wo, vec2(0.0), vec3(vec2(0.5 * alpha * alpha), 0.0))), f0, index);
}

// Returns the single-bounce albedo of the specular term. `deviation` is the mean deviation over the facets.
vec3 single_albedo(const vec3 f0, const vec2 albedo, const vec3 deviation) {
    return split_albedo(f0, albedo) + albedo.x * deviation;
}

// Returns the specular albedo of all bounces.
vec3 bounced_albedo(const vec3 f0, const ComplexIndex index, const vec2 albedo, const vec3 deviation, const float average_ideal) {
    if (!EXACT_FRESNEL) {
        return specular_albedo(f0, albedo, average_ideal);
    }
    vec3 mean = average_fresnel(f0) + average_deviation(f0, index);
    return single_albedo(f0, albedo, deviation) + (1.0 - albedo.x) * bounced_color(mean, average_ideal);
}

// Returns the mean deviation of the exact Fresnel term of the base along a cosine, or over the hemisphere for a cosine of 0.
vec3 base_deviation(const Surface s, const float alpha, const float cosine) {
    if (!EXACT_FRESNEL) {
        return vec3(0.0);
    }
    return cosine > 0.0 ? rough_deviation(alpha, cosine, s.diffuse_f0, s.diffuse_index) : average_deviation(s.diffuse_f0, s.diffuse_index);
}

// Returns the light that a single reflection lets through to the base along a cosine, or on average over the hemisphere for a cosine of 0.
vec3 passed_once(const Surface s, const float alpha, const float cosine) {
    vec2 albedo = cosine > 0.0 ? energy_albedo(alpha, cosine) : energy_average(alpha);
    return max(1.0 - single_albedo(s.diffuse_f0, albedo, base_deviation(s, alpha, cosine)), 0.0);
}

// Returns the light that enters the diffuse base along a cosine, or on average over the hemisphere for a cosine of 0.
vec3 entered_base(const Surface s, const float alpha, const float cosine) {
    vec2 average = energy_average(alpha), albedo = cosine > 0.0 ? energy_albedo(alpha, cosine) : average;
    vec3 deviation = base_deviation(s, alpha, cosine);
    return max(1.0 - bounced_albedo(s.diffuse_f0, s.diffuse_index, albedo, deviation, average.x), 0.0);
}

// Computes the bounces for a base of roughness alpha on a facet with this slope. Bounces within the relief are excluded, because more of the
// roughness becomes visible relief as the viewer approaches.
Bounces bounces_of(const Surface surface, const vec2 slope, float alpha) {
    Bounces b;
    b.about = frame_about(normal_of_slope(slope));
    b.wo = to_frame(b.about, surface.wo);
    b.wo.z = max(b.wo.z, 1e-3);
    b.alpha = alpha;
    b.facets = facet_bounces(alpha);
    b.specular = vec3(1.0);
    if (MULTISCATTERING) {
        b.specular = compensation_scale(surface.f0, energy_albedo(alpha, b.wo.z).x);
    } else if (BLEND && !is_fitted(surface.fit)) {
        b.specular = 1.0 - surface.albedo;
    }
    b.entered = entered_base(surface, alpha, b.wo.z);
    b.average = entered_base(surface, alpha, 0.0);
    b.albedo = CONSERVING ? passed_once(surface, alpha, 0.0) : diffuse_model_albedo(DIFFUSE_MODEL, b.wo.z, alpha, surface.albedo);
    return b;
}

// Returns the diffuse light from wi (tangent frame), divided by that of a Lambertian surface with the same albedo toward the viewer. The mean
// over all directions is 1.
vec3 bounced_light(const Bounces b, const Surface surface, const vec3 albedo, const vec3 wi) {
    vec3 towards = to_frame(b.about, wi);
    towards.z = max(towards.z, 1e-3);
    if (CONSERVING) {
        return passed_once(surface, b.alpha, towards.z) / max(b.albedo, 1e-4);
    }
    if (!MULTISCATTERING) {
        return diffuse_value(DIFFUSE_MODEL, b.wo, towards, b.alpha, albedo) / max(b.albedo, 1e-4);
    }
    vec3 entered_i = entered_base(surface, b.alpha, towards.z);
    vec3 facets = facet_albedo(b.facets, albedo);
    vec3 value = multiscattering_diffuse(b.wo, towards, b.facets, surface.diffuse_f0, facets, b.entered, entered_i, b.average);
    return value * LEADR_PI / max(albedo * b.entered, 1e-4);
}

#endif
