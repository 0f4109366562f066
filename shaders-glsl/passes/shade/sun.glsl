// The block of lights, and the fraction of a sun that reaches a point. Suns are all directional lights: the frame's own comes first,
// then those of its panorama.
#ifndef LEADR_SHADE_SUN
#define LEADR_SHADE_SUN
#include "../constants.glsl"

layout(std140) uniform Lighting {
    vec4 rays[3];                 // see surface_at
    mat4 shadow_from_world[MAX_SUNS]; // to [0,1] texture coordinates and depth
    vec4 camera_position;         // xyz; w: radiance of an emission of 1
    vec4 sun_direction[MAX_SUNS]; // xyz toward it, w: variance of its directions
    vec4 sun_irradiance[MAX_SUNS]; // rgb on a plane facing it
    vec4 point_position[MAX_POINT_LIGHTS];  // xyz; w: one over the square of its range, or 0
    vec4 point_intensity[MAX_POINT_LIGHTS]; // rgb
    vec4 point_falloff[MAX_POINT_LIGHTS];   // see point_reach
    vec4 viewport;                // width, height, pixels along one of the picture
    vec4 environment;             // x: face size of the cube, y: scale, z: shadow texel in world units, w: tangent of the lowest elevation seen behind all
    uvec4 draws;                  // sample, seed
} lighting;

uniform sampler2DArray shadow_maps; // a layer per sun

// Width of a pixel of this image at a point, in world units.
float pixel_width(vec3 position) {
    return distance(position, lighting.camera_position.xyz) * 2.0 * length(lighting.rays[0].xyz) / lighting.viewport.x;
}

// Width over which an edge sample averages the shadow map, in pixels of the picture. Its own width would be enough, but its geometry
// has finer bumps than that of the map, by up to half its relief (metres), and those must not shadow each other.
float edge_shadow_width(vec3 position, float relief) {
    return clamp(0.5 * relief / max(pixel_width(position) * lighting.viewport.z, 1e-9), 0.25, 1.0);
}

// Fraction of a sun that the macrosurface sees: 4 x 4 comparisons, bilinearly weighted, over a width of so many pixels of
// this image, or a texel of the map if that is wider. Smaller bumps cast their shadows through the slope statistics, so the point is
// lifted clear of them.
float sun_visibility(int sun, vec3 position, vec3 normal, float width) {
    float texel = lighting.environment.z;
    float stride = max(1.0, 0.5 * pixel_width(position) * width / texel);
    float sine = sqrt(max(1.0 - pow(dot(normal, lighting.sun_direction[sun].xyz), 2.0), 0.0));
    vec3 lifted = position + normal * (texel * stride * (1.0 + 2.0 * sine));
    vec3 s = (lighting.shadow_from_world[sun] * vec4(lifted, 1.0)).xyz;
    if (any(lessThan(s.xy, vec2(0.0))) || any(greaterThan(s, vec3(1.0)))) {
        return 1.0;
    }
    // The long shadows of a low sun reach beyond the depth of the map, where nothing is left to cast any.
    s.z = max(s.z, 0.0);
    ivec2 size = textureSize(shadow_maps, 0).xy;
    vec2 place = s.xy * vec2(size) / stride - 0.5;
    vec2 base = floor(place), fraction = place - base;
    float lit = 0.0;
    for (int y = -1; y <= 2; ++y) {
        for (int x = -1; x <= 2; ++x) {
            ivec2 at = ivec2((base + vec2(x, y) + 0.5) * stride);
            float depth = texelFetch(shadow_maps, ivec3(clamp(at, ivec2(0), size - 1), sun), 0).x;
            float wx = x == -1 ? 1.0 - fraction.x : (x == 2 ? fraction.x : 1.0);
            float wy = y == -1 ? 1.0 - fraction.y : (y == 2 ? fraction.y : 1.0);
            lit += depth <= s.z ? wx * wy : 0.0;
        }
    }
    return lit / 9.0;
}

#endif
