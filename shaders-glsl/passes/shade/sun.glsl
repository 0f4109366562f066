// The lights' uniform block, and the fraction of each light that reaches a point. Suns are all directional lights: the frame's
// own comes first, then those of its panorama.
#ifndef LEADR_SHADE_SUN
#define LEADR_SHADE_SUN
#include "../constants.glsl"
#include "leadr/frame.glsl"

layout(set = 1, std140) uniform Lighting {
    vec4 rays[3];                 // see surface_at
    mat4 shadow_from_world[MAX_SHADOW_MAPS]; // per light in order, to [0,1] texture coordinates and depth
    vec4 camera_position;         // xyz; w: radiance of an emission of 1
    vec4 sun_direction[MAX_SUNS]; // xyz toward it, w: variance of its directions
    vec4 sun_irradiance[MAX_SUNS]; // rgb on a plane facing it, w: tangent of its angular radius
    vec4 point_position[MAX_POINT_LIGHTS];  // xyz; w: 1 / range^2, or 0
    vec4 point_intensity[MAX_POINT_LIGHTS]; // rgb
    vec4 point_falloff[MAX_POINT_LIGHTS];   // see point_reach
    vec4 point_shadow[MAX_POINT_LIGHTS];    // x: texels of penumbra per unit of depth; y: size of a map texel at distance 1
    vec4 viewport;                // width, height, pixels per pixel of the final image
    vec4 environment;             // x: cube face size, z: shadow texel in world units, w: tangent of the lowest elevation behind all
    vec4 air;                     // rgb: extinction per metre
    uvec4 draws;                  // sample, seed
} lighting;

layout(set = 1) uniform sampler2DArray shadow_maps; // a layer per light: suns, then point lights

// Width of a pixel of this image at a point, in world units.
float pixel_width(const vec3 position) {
    return distance(position, lighting.camera_position.xyz) * 2.0 * length(lighting.rays[0].xyz) / lighting.viewport.x;
}

// Width over which an edge sample averages the shadow map, in pixels of the final image. It exceeds the sample's own width,
// because its geometry resolves finer bumps than the map, by up to half its relief (metres), which must not self-shadow.
float edge_shadow_width(const vec3 position, const float relief) {
    return clamp(0.5 * relief / max(pixel_width(position) * lighting.viewport.z, 1e-9), 0.25, 1.0);
}

// Taps of the blocker search, and of a penumbra.
const int SEARCH_TAPS = 16;
const int PENUMBRA_TAPS = 32;
const float GOLDEN_ANGLE = 2.39996323; // radians
// Up to this width, the 4 x 4 comparisons, a box of 3, approximate the penumbra.
const float NARROW = 2.0;
// Largest penumbra in texels per side; a larger one needs more taps for its area.
const float WIDEST = 48.0;
// Steepest receiver plane that is followed, as a tangent. Light at more grazing angles adds almost nothing.
const float STEEPEST = 4.0;

// Position of a point on a map, [0,1], and its depth there.
vec3 on_map(const int layer, const vec3 position) {
    vec4 s = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    return s.xyz / max(s.w, 1e-6);
}

// Receiver parameters for a shadow map.
struct Receiver {
    vec3 position;
    vec3 mesonormal;  // with the bumps under the pixel
    vec3 macronormal; // without them
    vec3 towards;     // to the light, unit
    float texel;      // of the map there, world units
};

// Gradient of depth over the map on the receiver's plane: linear in parallel and perspective views. s: position of the
// receiver.
vec2 plane_on_map(const int layer, const Receiver r, const vec3 s, const float steepest) {
    Frame along = frame_about(r.macronormal);
    vec3 a = on_map(layer, r.position + r.texel * along.x) - s, b = on_map(layer, r.position + r.texel * along.y) - s;
    float det = a.x * b.y - a.y * b.x;
    vec2 slope = vec2(a.z * b.y - a.y * b.z, a.x * b.z - a.z * b.x) / (abs(det) < 1e-20 ? 1e-20 : det);
    return slope * min(1.0, steepest / max(length(slope), 1e-20));
}

// Fraction of a light that reaches the macrosurface past its map, with a penumbra that grows with the blocker's distance
// (percentage-closer soft shadows, Fernando 2005). width: least width of the filter, pixels of this image. spread: texels of
// penumbra per side per unit of depth between blocker and receiver. steepest: STEEPEST in units of the map.
//
// The filter is at least a map texel and a pixel wide: 4 x 4 comparisons, bilinearly weighted. The slope statistics cast the
// shadows of smaller bumps, so the point is offset clear of them. For wide penumbrae it is instead moved toward the light by a
// fraction of their width. This moves no edges, and their blockers are far away, so no contact shadow is lost.
float map_visibility(const int layer, const Receiver r, const float width, const float spread, const float steepest) {
    float stride = max(1.0, 0.5 * pixel_width(r.position) * width / r.texel);
    float cosine = dot(r.mesonormal, r.towards);
    float lift = r.texel * (1.0 + 2.0 * sqrt(max(1.0 - cosine * cosine, 0.0)));
    vec3 s = on_map(layer, r.position + r.mesonormal * (lift * stride));
    if (any(lessThan(s.xy, vec2(0.0))) || any(greaterThan(s, vec3(1.0)))) {
        return 1.0;
    }
    ivec2 size = textureSize(shadow_maps, 0).xy;
    vec2 slope = plane_on_map(layer, r, on_map(layer, r.position), steepest) / vec2(size);
    float widest = clamp(spread * (1.0 - s.z), NARROW * stride, WIDEST);
    // Taps are denser at the centre to catch the thin ends of touching shadows. The long shadows of a low sun reach beyond the
    // depth of the map, where no casters exist. Depths there are 0, and the receiver's depth is clamped to 0.
    vec2 centre = s.xy * vec2(size);
    float blocked = 0.0, above = 0.0;
    [[unroll]] for (int i = 0; i < SEARCH_TAPS; ++i) {
        float angle = GOLDEN_ANGLE * float(i);
        ivec2 at = ivec2(floor(centre + vec2(cos(angle), sin(angle)) * (widest * (float(i) + 0.5) / float(SEARCH_TAPS))));
        float depth = texelFetch(shadow_maps, ivec3(clamp(at, ivec2(0), size - 1), layer), 0).x;
        float plane = s.z + dot(slope, vec2(at) + 0.5 - centre);
        if (depth > max(plane, 0.0)) {
            blocked += 1.0;
            above += depth - plane;
        }
    }
    bool partly = blocked > 0.0 && blocked < float(SEARCH_TAPS);
    float radius = min(spread * above / max(blocked, 1.0), WIDEST);
    bool wide = radius > NARROW * stride;
    if (wide) {
        s = on_map(layer, r.position + r.towards * (lift * (stride + 0.25 * radius)));
        centre = s.xy * vec2(size);
    }
    vec2 lattice = centre / stride - 0.5, base = floor(lattice), fraction = lattice - base;
    float lit = 0.0, angle = 0.0;
    // One loop for both with a non-uniform bound: drivers without divergent branches (lavapipe) would run the bodies of two
    // loops, and of an `if`, at every pixel.
    int taps = partly ? (wide ? PENUMBRA_TAPS : 16) : 1;
    for (int i = 0; i < taps; ++i) {
        vec2 node = vec2(i & 3, i >> 2) - 1.0;
        vec2 weight = mix(vec2(1.0), mix(fraction, 1.0 - fraction, lessThan(node, vec2(0.0))), notEqual(abs(node - 0.5), vec2(0.5)));
        vec2 disc = vec2(cos(angle), sin(angle)) * (radius * sqrt((float(i) + 0.5) / float(PENUMBRA_TAPS)));
        ivec2 at = ivec2(floor(wide ? centre + disc : (base + node + 0.5) * stride));
        float depth = texelFetch(shadow_maps, ivec3(clamp(at, ivec2(0), size - 1), layer), 0).x;
        float plane = wide ? s.z + dot(slope, vec2(at) + 0.5 - centre) : s.z;
        lit += depth <= max(plane, 0.0) ? (wide ? 1.0 : weight.x * weight.y) : 0.0;
        angle += GOLDEN_ANGLE;
    }
    return partly ? lit / (wide ? float(PENUMBRA_TAPS) : 9.0) : (blocked > 0.0 ? 0.0 : 1.0);
}

// Fraction of a sun that reaches the macrosurface.
float sun_visibility(const int sun, const vec3 position, const vec3 mesonormal, const vec3 macronormal, const float width) {
    Receiver r = Receiver(position, mesonormal, macronormal, lighting.sun_direction[sun].xyz, lighting.environment.z);
    // The map is as deep as it is wide.
    float spread = lighting.sun_irradiance[sun].w * float(textureSize(shadow_maps, 0).x);
    return map_visibility(sun, r, width, spread, STEEPEST);
}

// Fraction of a point light that reaches the macrosurface. Its map covers the bounding sphere of all casters; nothing outside
// is shadowed.
float point_visibility(const int layer, const int point, const vec3 position, const vec3 mesonormal, const vec3 macronormal,
                       const float width) {
    vec3 towards = normalize(lighting.point_position[point].xyz - position);
    vec4 clip = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    float texel = lighting.point_shadow[point].y * max(clip.w, 1e-6);
    Receiver r = Receiver(position, mesonormal, macronormal, towards, texel);
    // Ratio of a map's width to its distance: it divides gradients of depth.
    float wide = lighting.point_shadow[point].y * float(textureSize(shadow_maps, 0).x);
    float steepest = STEEPEST * wide * clip.z / max(clip.w, 1e-6);
    float lit = map_visibility(layer, r, width, lighting.point_shadow[point].x, steepest);
    return clip.w > 0.0 ? lit : 1.0;
}

#endif
