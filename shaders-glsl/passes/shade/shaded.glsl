// A pixel from what filtering found there.
#ifndef LEADR_SHADE_SHADED
#define LEADR_SHADE_SHADED
#include "families.glsl"

// The surface that is seen at a place of the image, in pixels, at a depth (reversed).
Surface surface_seen(const FilteredSurface filtered, const vec2 place, const float depth) {
    Surface surface = surface_at(filtered, lighting.camera_position.xyz, pixel_ray(place), lighting.rays[2].w, depth);
    surface.pixel = uvec2(place);
    if (SKY_OCCLUSION) {
        surface.sky = sky_seen(surface.position, surface.frame.z);
    }
    return surface;
}

// Radiance toward the viewer; a marker where the inside of a surface is seen.
vec3 surface_radiance(const Surface surface) {
    if (TELLS_LIGHT) {
        return vec3(light_share(surface), SKY_OCCLUSION ? surface.sky.w : 1.0, 0.0);
    }
    if (surface.inside) {
        return vec3(1.0, 0.0, 1.0);
    }
    // What a surface emits counts among the diffuse light of lights, which it may be one of; where nothing is lit it shows as albedo does.
    vec3 emitted = DIFFUSE_LIGHTS || FAMILY == FAMILY_UNLIT ? surface.emission * lighting.camera_position.w : vec3(0.0);
    return family_radiance(surface) + emitted;
}

// The same for a pixel without edge samples.
vec3 shaded(const FilteredSurface filtered, const vec2 place, const float depth) {
    return surface_radiance(surface_seen(filtered, place, depth));
}

#endif
