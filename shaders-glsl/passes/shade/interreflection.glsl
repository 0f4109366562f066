// Light that the facets of the relief send to each other (leadr/integrals/interreflection.glsl).
#ifndef LEADR_SHADE_INTERREFLECTION
#define LEADR_SHADE_INTERREFLECTION
#include "classes.glsl"
#include "harmonics.glsl"
#include "leadr/integrals/interreflection.glsl"
#include "leadr/visible/shadowed_environment.glsl"

// Returns the mean reflectance over the hemisphere, weighted by the cosine.
vec3 hemisphere_fresnel(const vec3 f0, const ComplexIndex index) {
    vec3 schlick = f0 + (grazing_reflectance(f0) - f0) * (1.0 / 21.0);
    return EXACT_FRESNEL ? schlick + average_deviation(f0, index) : schlick;
}

// Returns the fraction of the hemisphere that bumps larger than the footprint hide.
float hidden_by_horizon(const Surface surface) {
    if (!HAS_HORIZON) {
        return 0.0;
    }
    vec3 weight = horizon_hidden(surface.mean_slope, surface.horizon).weight;
    return clamp(dot(weight, normal_of_slope(surface.mean_slope)), 0.0, 1.0);
}

// Returns the radiosity of the relief under a light. up is the mean normal; share, m and S are the shares and slopes of the classes.
vec3 relief_radiosity_by(const Light light, const ReliefBounces bounces, const vec3 up, const vec4 share, const vec2 m[4],
                         const vec3 S[4]) {
    vec4 lit = share;
    if (BY_CLASS) {
        vec4 depths = depths_towards(light.wi);
        [[unroll]] for (int k = 0; k < CLASSES; ++k) {
            lit[k] *= visible_area(light.wi, m[k], S[k]) / (1.0 + depths[k]);
        }
        lit /= max(dot(lit, vec4(1.0)), 1e-9);
    }
    return relief_radiosity(bounces, light.irradiance * max(dot(up, light.wi), 0.0), lit);
}

// Returns the radiance of the relief in directions that other facets block, from the lights in pixel_lights and the other lamps. larger is the result of
// hidden_by_horizon.
vec3 relief_radiance(const Surface surface, const float larger) {
    vec4 share = vec4(1.0, 0.0, 0.0, 0.0), depth = vec4(0.0);
    vec2 m[4] = vec2[4](surface.mean_slope, vec2(0.0), vec2(0.0), vec2(0.0));
    vec3 S[4] = vec3[4](surface.slope_covariance, vec3(0.0), vec3(0.0), vec3(0.0));
    vec3 albedo[4] = vec3[4](surface.albedo, vec3(0.0), vec3(0.0), vec3(0.0));
    if (CLASSES > 1) {
        FacetClasses c = pixel_classes;
        share = c.share;
        depth = c.sky_depth;
        [[unroll]] for (int k = 0; k < CLASSES; ++k) {
            m[k] = c.mean[k];
            S[k] = c.covariance[k];
            albedo[k] = c.material[k].rgb;
        }
    }
    for (int k = 0; k < 4; ++k) {
        albedo[k] = albedo[k] * (1.0 - hemisphere_fresnel(surface.diffuse_f0, surface.diffuse_index)) + hemisphere_fresnel(surface.f0, surface.index);
    }
    ClassSky sky = class_sky(CLASSES, share, m, S, depth);
    sky.blocked = 1.0 - (1.0 - sky.blocked) * (1.0 - larger);
    ReliefBounces bounces = relief_bounces(sky, albedo);
    vec3 up = normal_of_slope(sky.mean);
    vec3 radiosity = vec3(0.0);
    if (SPECULAR_ENVIRONMENT || DIFFUSE_ENVIRONMENT) {
        vec3 irradiance = sh_irradiance(environment_sh(), from_frame(surface.frame, up)) + rest_irradiance(surface, up);
        radiosity += relief_radiosity(bounces, ambient_on_diffuse(surface, surface.albedo) * max(irradiance, 0.0), sky.flux);
    }
    [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
        if (on_diffuse(number) || in_specular(number)) {
            radiosity += relief_radiosity_by(pixel_lights[number], bounces, up, share, m, S);
        }
    }
    if (MORE_LAMPS && (DIFFUSE_LIGHTS || SPECULAR_LIGHTS)) {
        Light light;
        float passed;
        for (int lamp = next_lamp(LAMPS, surface, light, passed); lamp < lamp_count(surface.wo.z);
             lamp = next_lamp(lamp + 1, surface, light, passed)) {
            radiosity += relief_radiosity_by(light, bounces, up, share, m, S);
        }
    }
    return radiosity / LEADR_PI;
}

// Returns the fraction of the hemisphere of the visible facets in which they see the relief.
float relief_seen(const Surface surface, const float larger) {
    float sky = 1.0;
    if (BY_CLASS && SHADOWING != LEADR_SHADOWING_NONE) {
        sky = surface.sky_light.a;
    } else if (SHADOWING != LEADR_SHADOWING_NONE && SHADOWING != LEADR_SHADOWING_SMITH) {
        sky = bent_normal(surface.wo, surface.mean_slope, surface.slope_covariance).open;
    }
    return 1.0 - sky * (1.0 - larger);
}

#endif
