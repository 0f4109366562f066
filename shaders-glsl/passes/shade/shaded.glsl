// A pixel from what filtering found there.
#ifndef LEADR_SHADE_SHADED
#define LEADR_SHADE_SHADED
#include "families.glsl"

// The surface that is seen at a place of the image, in pixels, at a depth (reversed).
Surface surface_seen(FilteredSurface filtered, vec2 place, float depth) {
    Surface surface = surface_at(filtered, lighting.camera_position.xyz, pixel_ray(place), lighting.rays[2].w, depth);
    surface.pixel = uvec2(place);
    return surface;
}

// Radiance toward the viewer; a marker where the inside of a surface is seen.
vec3 surface_radiance(Surface surface) {
    return surface.inside ? vec3(1.0, 0.0, 1.0) : family_radiance(surface, lighting.environment.y);
}

// The same for a pixel without edge samples.
vec3 shaded(FilteredSurface filtered, vec2 place, float depth) {
    return surface_radiance(surface_seen(filtered, place, depth));
}

#endif
