// Shades a pixel from filtered values.
#ifndef LEADR_SHADE_SHADED
#define LEADR_SHADE_SHADED
#include "air.glsl"
#include "families.glsl"

// Returns the surface at a position in the image, in pixels, from its reversed depth.
Surface surface_seen(const FilteredSurface filtered, const vec2 pixel, const float depth) {
    Surface surface = surface_at(filtered, lighting.camera_position.xyz, pixel_ray(pixel), lighting.rays[2].w, depth);
    surface.pixel = uvec2(pixel);
    if (SKY_OCCLUSION) {
        surface.sky = sky_seen(surface.position, surface.frame.z);
    }
    return surface;
}

// Returns the radiance toward the viewer, or a marker colour where a back face is visible.
vec3 surface_radiance(const Surface surface) {
    if (TELLS_LIGHT) {
        return vec3(light_share(surface), SKY_OCCLUSION ? surface.sky.w : 1.0, 0.0);
    }
    if (surface.inside) {
        return vec3(1.0, 0.0, 1.0);
    }
    // Emission counts as diffuse light of lights, because the surface may be a light itself. Unlit rendering shows emission like albedo.
    vec3 emitted = DIFFUSE_LIGHTS || FAMILY == FAMILY_UNLIT ? surface.emission * lighting.camera_position.w : vec3(0.0);
    if (COATED && FAMILY == FAMILY_LEADR) {
        emitted *= 1.0 - coat_over(surface).outward;
    }
    vec3 reach = surface.position - lighting.camera_position.xyz;
    return through_air(family_radiance(surface) + emitted, reach, lighting.air.rgb, background_cube, lighting.environment.x);
}

// Returns the radiance of a pixel without edge samples.
vec3 shaded(const FilteredSurface filtered, const vec2 pixel, const float depth) {
    return surface_radiance(surface_seen(filtered, pixel, depth));
}

#endif
