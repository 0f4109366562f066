// The functions that shade a pixel, one per family of techniques.
#ifndef LEADR_SHADE_FAMILIES
#define LEADR_SHADE_FAMILIES
#include "energy.glsl"
#include "facet_frame.glsl"
#include "harmonics.glsl"
#include "leadr.glsl"
#include "lighting.glsl"
#include "leadr/facets/ggx.glsl"
#include "leadr/facets/shortened_normals.glsl"
#include "leadr/materials/classic.glsl"
#include "leadr/integrals/light_size.glsl"
#include "leadr/integrals/sh.glsl"

// The values of FAMILY.
const int FAMILY_UNLIT = 0;       // shows the albedo
const int FAMILY_BLINN_PHONG = 1; // a Blinn-Phong lobe about the mean normal
const int FAMILY_TOKSVIG = 2;     // like FAMILY_BLINN_PHONG, with roughness from the length of the mean normal
const int FAMILY_LEAN = 3;        // a Beckmann lobe of the slopes, without projected areas
const int FAMILY_LEADR = 4;       // integrals over the visible slopes
const int FAMILY_GLOSS = 5;       // a GGX lobe about the mean normal, with roughness from shortened normals

// Returns the normal distribution of the lobe. For Blinn-Phong it is about the mean normal, and for LEAN in the tangent frame.
float classic_ndf(const vec3 wh, const vec3 n, const float exponent, const vec2 m, const vec3 S) {
    return FAMILY == FAMILY_LEAN ? beckmann_ndf(wh, m, S) : blinn_phong_ndf(dot(wh, n), exponent);
}

// Returns the normal distribution of the lobe, widened by the size of light `i`.
float classic_light_ndf(const int i, const Light light, const vec3 wo, const vec3 wh, const vec3 n, float exponent, const vec2 m, vec3 S) {
    if (of_panorama(i)) {
        S = clamp_covariance(S + light_slope_covariance(wo, light.wi, light.variance));
        exponent = max(1.0 / (blinn_phong_variance(exponent) + light_normal_variance(dot(wo, wh), light.variance)) - 2.0, 0.0);
    }
    return classic_ndf(wh, n, exponent, m, S);
}

// Returns the light `i` that the surface reflects. n is the mean normal; exponent and S give the width of the lobe.
vec3 classic_reflected(const int i, const Light light, const Surface surface, const vec3 albedo, const vec3 n, const float exponent,
                       const vec3 S) {
    vec3 wo = surface.wo;
    vec3 scattered = vec3(0.0);
    if (on_diffuse(i)) {
        scattered += albedo / LEADR_PI;
    }
    if (in_specular(i)) {
        vec3 h = wo + light.wi;
        vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
        scattered += fresnel_of(surface, dot(wo, wh)) * (0.25 * classic_light_ndf(i, light, wo, wh, n, exponent, surface.mean_slope, S));
    }
    return light.irradiance * scattered * max(dot(n, light.wi), 0.0);
}

// Shades with techniques before LEADR, which use a lobe about one mean normal, without projected areas. Specular light is F D / 4 times the
// cosine, which is a microfacet BRDF with implicit masking. Diffuse light is the cosine. The environment is sampled once, in the reflected
// direction, blurred to the width of the lobe.
vec3 classic_radiance(const Surface surface) {
    vec2 m = surface.mean_slope;
    vec3 wo = surface.wo;
    vec3 n = normal_of_slope(m);
    vec3 S = add_roughness(surface.slope_covariance, surface.alpha);
    float exponent = blinn_phong_exponent(surface.alpha);
    if (FAMILY == FAMILY_TOKSVIG) {
        exponent = toksvig_exponent(exponent, toksvig_variance(normal_variance(m, surface.slope_covariance)));
    }
    vec3 fresnel = fresnel_of(surface, dot(wo, n));
    vec3 albedo = surface.albedo * (1.0 - diffuse_fresnel_of(surface, dot(wo, n)));
    vec3 radiance = vec3(0.0);

    if (SPECULAR_ENVIRONMENT) {
        float variance = FAMILY == FAMILY_LEAN ? normal_variance(m, S) : blinn_phong_variance(exponent);
        vec3 wi = 2.0 * dot(wo, n) * n - wo;
        radiance += ambient_in_specular(surface) * fresnel * environment_radiance(surface, wi, lobe_lod(variance, lighting.environment.x));
    }
    if (DIFFUSE_ENVIRONMENT) {
        radiance += albedo * ambient_on_diffuse(surface, albedo) * (1.0 / LEADR_PI) * max(sh_irradiance(environment_sh(), from_frame(surface.frame, n)), 0.0);
    }
    if (any_on_diffuse() || any_in_specular()) {
        [[unroll]] for (int i = 0; i < LIGHTS; ++i) {
            radiance += classic_reflected(i, light_at(i, surface), surface, albedo, n, exponent, S);
        }
        if (MORE_LAMPS) {
            Light light;
            float passed;
            for (int lamp = next_lamp(LAMPS, surface, light, passed); lamp < lamp_count(surface.wo.z);
                 lamp = next_lamp(lamp + 1, surface, light, passed)) {
                radiance += classic_reflected(ANY_LAMP, light, surface, albedo, n, exponent, S);
            }
        }
    }
    return radiance;
}

// Returns the specular response of GGX facets about z to a light, without the Fresnel term. `square` is the square of the roughness.
float gloss_specular(const vec3 wo, const vec3 wi, const vec3 wh, const float square) {
    vec3 roughness = vec3(vec2(square), 0.0);
    return 0.25 * ggx_ndf(wh, vec2(0.0), roughness) * ggx_masking_shadowing(wo, wi, vec2(0.0), roughness, true);
}

// Adds the light `i` that a GGX lobe of this roughness and a diffuse base reflect.
void add_gloss_light(inout vec3 radiance, const int i, const Light light, const Surface surface, const Bounces b, const vec3 diffuse,
                     const float alpha) {
    vec3 wi = to_frame(b.about, light.wi);
    if (wi.z > 0.0) {
        vec3 scattered = vec3(0.0);
        if (on_diffuse(i)) {
            vec3 bounced = !LAMBERTIAN ? bounced_light(b, surface, surface.albedo, light.wi) : vec3(1.0);
            scattered += diffuse * bounced * (wi.z / LEADR_PI);
        }
        if (in_specular(i)) {
            vec3 h = b.wo + wi;
            vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
            float cosine = dot(b.wo, wh);
            float square = alpha * alpha + (of_panorama(i) ? 2.0 * light_normal_variance(cosine, light.variance) : 0.0);
            vec3 fresnel = fresnel_of(surface, cosine) * b.specular;
            scattered += fresnel * gloss_specular(b.wo, wi, wh, min(square, 1.0));
        }
        radiance += light.irradiance * scattered;
    }
}

// Shades with shortened normals (Chan 2018): a GGX lobe about the mean normal, whose roughness follows from the length of the mean normal.
// The length is the product of the lengths for relief and base.
vec3 gloss_radiance(const Surface surface) {
    vec2 m = surface.mean_slope;
    float relief = tail_mean_ratio(inversesqrt(max(normal_variance(m, surface.slope_covariance), 1e-12)));
    float base = normal_shortening(LEADR_GGX_MACRO, surface.alpha);
    float alpha = clamp(alpha_of_shortening(LEADR_GGX_MACRO, relief + base - relief * base), 1e-3, 1.0);
    Bounces b = bounces_of(surface, m, alpha);
    vec2 energy = energy_albedo(alpha, b.wo.z);
    vec3 deviation = vec3(0.0), diffuse_deviation = vec3(0.0);
    if (EXACT_FRESNEL) {
        deviation = rough_deviation(alpha, b.wo.z, surface.f0, surface.index);
        diffuse_deviation = rough_deviation(alpha, b.wo.z, surface.diffuse_f0, surface.diffuse_index);
    }
    vec3 reflected = single_albedo(surface.f0, energy, deviation);
    vec3 diffuse = surface.albedo * (1.0 - single_albedo(surface.diffuse_f0, energy, diffuse_deviation) / max(energy.x, 1e-3));
    if (MULTISCATTERING) {
        reflected = bounced_albedo(surface.f0, surface.index, energy, deviation, energy_average(alpha).x);
        diffuse = surface.albedo * b.entered;
    }
    if (BLEND) {
        reflected *= b.specular;
    }
    diffuse = (COAT_IN_MODEL ? surface.albedo : diffuse) * b.albedo;
    vec3 albedo = surface.albedo;
    vec3 radiance = vec3(0.0);
    if (SPECULAR_ENVIRONMENT) {
        vec3 wi = from_frame(b.about, lobe_axis(alpha, b.wo));
        vec3 seen = vec3(0.0);
        // GGX is a mixture of Gaussian lobes. Reflected directions rotate by twice the angle of the normals.
        for (int k = 1; k < LEADR_GGX_LOBES; ++k) {
            GaussianLobe lobe = ggx_lobe(DisplacedGgx(1.0, vec3(vec2(alpha * alpha), 0.0)), k);
            seen += lobe.weight * lobe_radiance(surface, wi, 4.0 * lobe.S.x);
        }
        radiance += ambient_in_specular(surface) * reflected * cone_specular_share(surface, alpha) * seen;
    }
    if (DIFFUSE_ENVIRONMENT) {
        vec3 c[9] = environment_sh();
        vec3 irradiance = max(sh_irradiance(c, from_frame(surface.frame, normal_of_slope(m))), 0.0);
        vec3 ambient = (1.0 / LEADR_PI) * ambient_on_diffuse(surface, albedo) * cone_diffuse(surface, albedo, c);
        radiance += diffuse * ambient * irradiance;
    }
    if (any_on_diffuse() || any_in_specular()) {
        [[unroll]] for (int i = 0; i < LIGHTS; ++i) {
            add_gloss_light(radiance, i, light_at(i, surface), surface, b, diffuse, alpha);
        }
        if (MORE_LAMPS) {
            Light light;
            float passed;
            for (int lamp = next_lamp(LAMPS, surface, light, passed); lamp < lamp_count(surface.wo.z);
                 lamp = next_lamp(lamp + 1, surface, light, passed)) {
                add_gloss_light(radiance, ANY_LAMP, light, surface, b, diffuse, alpha);
            }
        }
    }
    return radiance;
}

// Returns the surface of a normal-map facet that faces away, where <wo, wm> is clamped at 0. Such a facet has the reflectance of grazing
// incidence, but reflects no visible light.
Surface facing_away(Surface surface) {
    surface.albedo *= 1.0 - grazing_reflectance(surface.diffuse_f0);
    surface.f0 = surface.diffuse_f0 = vec3(0.0);
    set_index(surface);
    surface.fit = 0u;
    vec3 n = normal_of_slope(surface.mean_slope);
    surface.wo = normalize(surface.wo + n * (1e-3 - dot(surface.wo, n)));
    return surface;
}

// Returns the radiance toward the viewer, by the family of the technique.
vec3 family_radiance(Surface surface) {
    if (FAMILY == FAMILY_UNLIT) {
        return surface.albedo;
    }
    if (FAMILY == FAMILY_GLOSS) {
        return gloss_radiance(surface);
    }
    if (FAMILY != FAMILY_LEADR) {
        return classic_radiance(surface);
    }
    if (NORMAL_MAPPED) {
        if (FINEST_LEVEL && meso_area(surface.wo, surface.mean_slope) <= 0.0) {
            surface = facing_away(surface);
        }
    } else if (TILTS_TO_EDGE) {
        vec2 tilt = tilt_to_edge(surface.wo, surface.mean_slope);
        surface.mean_slope += tilt;
        surface.slope_covariance += vec3(tilt * tilt, tilt.x * tilt.y);
        [[unroll]] for (int k = 0; CLASSES > 1 && k < CLASSES; ++k) {
            pixel_classes.mean[k] += tilt;
            pixel_classes.covariance[k] += vec3(tilt * tilt, tilt.x * tilt.y);
        }
    }
    if (FINEST_LEVEL && (FACET_FRAME || is_fitted(surface.fit))) {
        surface = in_facet_frame(surface);
    }
    return relief_shaded(surface);
}

#endif
