// The lights: suns and lamps with their shadows, and the environment.
#ifndef LEADR_SHADE_LIGHTING
#define LEADR_SHADE_LIGHTING
#include "lamps.glsl"
#include "surface.glsl"
#include "relief.glsl"
#include "leadr/slopes/grid.glsl"
#include "leadr/visible/kernel.glsl"
#include "settings.glsl"
#include "sky_visibility.glsl"

layout(set = 1) uniform samplerCube environment_cube;  // the environment without the panorama's suns; mip levels use a box filter
layout(set = 1) uniform samplerCube environment_lobes; // the same environment, filtered by a smooth kernel
layout(set = 1) uniform samplerCube irradiance_rest;   // the environment's irradiance of orders above 2
layout(set = 1) uniform samplerCube background_cube;   // the environment with the panorama's suns

struct Light {
    vec3 wi;         // direction toward the light, in the tangent frame
    vec3 irradiance; // irradiance on a plane facing the light
    float variance;  // variance of the light's directions
    float nearness;  // inverse of the distance, or 0
};

// Returns the smallest filter width of a shadow map, in pixels of this image.
float shadow_width(const Surface surface) {
    float edge = EDGES == EDGES_ARE_SHADED ? edge_shadow_width(surface.position, surface.relief) : 1.0;
    return lighting.viewport.z * edge;
}

// Returns a lamp without shadows.
Light lamp_sent(const Lamp lamp, const Surface surface) {
    vec3 towards;
    vec3 irradiance = lamp_irradiance(lamp, surface.position, towards);
    float nearness = 0.0;
    if (PER_LIGHT_KERNEL && lamp.position.w > 0.0) {
        vec3 d = lamp.position.xyz - surface.position;
        nearness = inversesqrt(max(dot(d, d), 1e-8));
    }
    return Light(to_frame(surface.frame, towards), irradiance, 0.0, nearness);
}

// Returns light `i` without shadows.
Light light_sent(const int i, const Surface surface) {
    if (LAMPS == 0 || i < SUNS) {
        return Light(to_frame(surface.frame, lighting.sun_direction[i].xyz), lighting.sun_irradiance[i].rgb, lighting.sun_direction[i].w, 0.0);
    }
    return lamp_sent(lamps[i - SUNS], surface);
}

// Returns the fraction of the light that passes the relief and the shadow casters.
float light_passed(const int i, const Surface surface, const Light light) {
    float seen = relief_visibility(surface, light.wi, sqrt(light.variance));
    if (!MAPPED_SHADOWS) {
        return seen;
    }
    vec3 mesonormal = from_frame(surface.frame, normal_of_slope(surface.mean_slope));
    float width = shadow_width(surface);
    // The shadow map and the horizon contain the same bumps, so the smaller visibility counts, not the product of both.
    if (LAMPS == 0 || i < SUNS) {
        float sunlit = surface.joined < 1.0 ? sun_visibility(i, surface.position, mesonormal, surface.frame.z, width) : 0.0;
        return min(seen, mix(sunlit, i == 0 ? surface.sunlit : surface.more_sunlit[max(i - 1, 0)], surface.joined));
    }
    return min(seen, lamp_visibility(i, i - SUNS, surface.position, mesonormal, surface.frame.z, width));
}

Light light_at(const int i, const Surface surface) {
    Light light = light_sent(i, surface);
    light.irradiance *= light_passed(i, surface, light);
    return light;
}

// Returns the number of the first lamp from `number` on that lights the surface, or the number of lamps. passed is the fraction of the light that
// passes the relief. Pixels outside the range or the cone of a lamp skip it, so the lamp costs only this test.
int next_lamp(int number, const Surface surface, out Light light, out float passed) {
    for (int count = lamp_count(surface.wo.z); number < count; ++number) {
        light = lamp_sent(lamps[number], surface);
        if (any(greaterThan(light.irradiance, vec3(0.0)))) {
            break;
        }
    }
    // The horizon belongs to the whole relief of the pixel.
    Surface whole = surface;
    if (CLASSES > 1) {
        whole.mean_slope = surface.whole_mean;
    }
    passed = relief_visibility(whole, light.wi, 0.0);
    light.irradiance *= passed;
    return number;
}

// Returns the unshadowed fraction of the light from suns and lamps, or 1 if there are none.
float light_share(const Surface surface) {
    float sent = 0.0, passed = 0.0;
    for (int i = 0; i < LIGHTS; ++i) {
        Light light = light_sent(i, surface);
        float power = dot(light.irradiance, vec3(0.2126, 0.7152, 0.0722));
        sent += power;
        passed += power * light_passed(i, surface, light);
    }
    if (MORE_LAMPS) {
        for (int number = LAMPS; number < lamp_count(surface.wo.z); ++number) {
            Light light = lamp_sent(lamps[number], surface);
            float power = dot(light.irradiance, vec3(0.2126, 0.7152, 0.0722));
            sent += power;
            passed += power * relief_visibility(surface, light.wi, 0.0);
        }
    }
    return sent > 0.0 ? passed / sent : 1.0;
}

// Returns the ambient visibility for a diffuse surface of this albedo.
vec3 ambient_on_diffuse(const Surface surface, const vec3 albedo) {
    return SKY_OCCLUSION ? sky_on_diffuse(surface.sky, surface.accessibility, albedo) : vec3(surface.accessibility);
}

// Returns the ambient visibility for the specular term about the mean normal.
float ambient_in_specular(const Surface surface) {
    if (!SKY_OCCLUSION) {
        return surface.accessibility;
    }
    vec3 n = normal_of_slope(surface.mean_slope);
    vec3 towards = from_frame(surface.frame, 2.0 * dot(surface.wo, n) * n - surface.wo);
    return sky_in_specular(surface.sky, surface.accessibility, towards);
}

// Returns the ray through a point of the image, in the form that surface_at expects.
vec3 pixel_ray(const vec2 pixel) {
    vec2 ndc = (pixel / lighting.viewport.xy) * 2.0 - 1.0;
    return lighting.rays[2].xyz + ndc.x * lighting.rays[0].xyz + ndc.y * lighting.rays[1].xyz;
}

// Returns the radiance along a ray that hits nothing.
vec3 sky_radiance(vec3 ray) {
    ray.z = max(ray.z, lighting.environment.w * length(ray.xy));
    return textureLod(background_cube, ray, 0.0).rgb;
}

// Returns the radiance from the direction wi of the tangent frame.
vec3 environment_radiance(const Surface surface, const vec3 wi, const float lod) {
    return textureLod(environment_cube, from_frame(surface.frame, wi), lod).rgb;
}

// Returns the radiance from wi, filtered by a smooth kernel of this variance.
vec3 lobe_radiance(const Surface surface, const vec3 wi, const float variance) {
    float size = float(textureSize(environment_lobes, 0).x);
    return textureLod(environment_lobes, from_frame(surface.frame, wi), kernel_lod(variance, size)).rgb;
}

// Returns the irradiance of orders above 2, for a normal n of any length. The result is zero with the paper's grid, which uses order 2.
vec3 rest_irradiance(const Surface surface, const vec3 n) {
    return VISIBLE_SLOPES ? textureLod(irradiance_rest, from_frame(surface.frame, n), 0.0).rgb : vec3(0.0);
}

#endif
