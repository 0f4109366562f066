// The block of lights, and the fraction of each that reaches a point. Suns are all directional lights: the frame's own comes first,
// then those of its panorama.
#ifndef LEADR_SHADE_SUN
#define LEADR_SHADE_SUN
#include "../constants.glsl"
#include "leadr/frame.glsl"

layout(set = 1, std140) uniform Lighting {
    vec4 rays[3];                 // see surface_at
    mat4 shadow_from_world[MAX_SHADOW_MAPS]; // of each light in their order, to [0,1] texture coordinates and depth
    vec4 camera_position;         // xyz; w: radiance of an emission of 1
    vec4 sun_direction[MAX_SUNS]; // xyz toward it, w: variance of its directions
    vec4 sun_irradiance[MAX_SUNS]; // rgb on a plane facing it, w: tangent of its angular radius
    vec4 point_position[MAX_POINT_LIGHTS];  // xyz; w: one over the square of its range, or 0
    vec4 point_intensity[MAX_POINT_LIGHTS]; // rgb
    vec4 point_falloff[MAX_POINT_LIGHTS];   // see point_reach
    vec4 point_shadow[MAX_POINT_LIGHTS];    // x: texels of penumbra per unit of depth, y: texel of its map at distance 1
    vec4 viewport;                // width, height, pixels along one of the picture
    vec4 environment;             // x: face size of the cube, z: shadow texel in world units, w: tangent of the lowest elevation seen behind all
    uvec4 draws;                  // sample, seed
} lighting;

layout(set = 1) uniform sampler2DArray shadow_maps; // a layer per light: suns, then point lights

// Width of a pixel of this image at a point, in world units.
float pixel_width(const vec3 position) {
    return distance(position, lighting.camera_position.xyz) * 2.0 * length(lighting.rays[0].xyz) / lighting.viewport.x;
}

// Width over which an edge sample averages the shadow map, in pixels of the picture. Its own width would be enough, but its geometry
// has finer bumps than that of the map, by up to half its relief (metres), and those must not shadow each other.
float edge_shadow_width(const vec3 position, const float relief) {
    return clamp(0.5 * relief / max(pixel_width(position) * lighting.viewport.z, 1e-9), 0.25, 1.0);
}

// Taps of the search for what blocks a light, and of a penumbra.
const int SEARCH_TAPS = 16;
const int PENUMBRA_TAPS = 32;
const float GOLDEN_ANGLE = 2.39996323; // radians
// Penumbrae of no more strides have the profile of the 4 x 4 comparisons, a box of 3, as nearly as those can tell.
const float NARROW = 2.0;
// Widest penumbra in texels to either side: more would be too few taps for its area.
const float WIDEST = 48.0;
// Steepest plane of a receiver that is followed, as a tangent: light that grazes more adds next to nothing.
const float STEEPEST = 4.0;

// Place of a point on a map, [0,1], and its depth there.
vec3 on_map(const int layer, const vec3 position) {
    vec4 s = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    return s.xyz / max(s.w, 1e-6);
}

// How a map sees a receiver.
struct Receiver {
    vec3 position;
    vec3 mesonormal;  // with the bumps under the pixel
    vec3 macronormal; // without
    vec3 towards;     // the light, unit
    float texel;      // of the map there, world units
};

// Change of the depth along a map over the plane of a receiver: linear in parallel and in perspective views. s: the receiver's place.
vec2 plane_on_map(const int layer, const Receiver r, const vec3 s, const float steepest) {
    Frame along = frame_about(r.macronormal);
    vec3 a = on_map(layer, r.position + r.texel * along.x) - s, b = on_map(layer, r.position + r.texel * along.y) - s;
    float det = a.x * b.y - a.y * b.x;
    vec2 slope = vec2(a.z * b.y - a.y * b.z, a.x * b.z - a.z * b.x) / (abs(det) < 1e-20 ? 1e-20 : det);
    return slope * min(1.0, steepest / max(length(slope), 1e-20));
}

// Fraction of a light that the macrosurface sees past its map, with a penumbra that grows with the distance of what blocks it
// (percentage-closer soft shadows, Fernando 2005). width: least width of the filter, pixels of this image. spread: texels of penumbra to
// either side per unit of depth between blocker and receiver. steepest: STEEPEST in units of the map.
//
// A texel of the map and the pixel are the least width: 4 x 4 comparisons, bilinearly weighted. Smaller bumps cast their shadows through
// the slope statistics, so the point is lifted clear of them. For wide penumbrae it is moved toward the light instead, by a part of their
// width, which moves no edges; they belong to far blockers, so no contact is lost.
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
    // Taps are denser in the middle, so that the thin ends of what touches the receiver are not missed. The long shadows of a low sun
    // reach beyond the depth of the map, where nothing is left to cast any: there depths are 0, and the receiver's count as no less.
    vec2 place = s.xy * vec2(size);
    float blocked = 0.0, above = 0.0;
    [[unroll]] for (int i = 0; i < SEARCH_TAPS; ++i) {
        float angle = GOLDEN_ANGLE * float(i);
        ivec2 at = ivec2(floor(place + vec2(cos(angle), sin(angle)) * (widest * (float(i) + 0.5) / float(SEARCH_TAPS))));
        float depth = texelFetch(shadow_maps, ivec3(clamp(at, ivec2(0), size - 1), layer), 0).x;
        float plane = s.z + dot(slope, vec2(at) + 0.5 - place);
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
        place = s.xy * vec2(size);
    }
    vec2 lattice = place / stride - 0.5, base = floor(lattice), fraction = lattice - base;
    float lit = 0.0, angle = 0.0;
    // One loop for both, whose end differs from pixel to pixel: drivers without divergent branches (lavapipe) would go through the
    // bodies of two, and of `if`, everywhere.
    int taps = partly ? (wide ? PENUMBRA_TAPS : 16) : 1;
    for (int i = 0; i < taps; ++i) {
        vec2 node = vec2(i & 3, i >> 2) - 1.0;
        vec2 weight = mix(vec2(1.0), mix(fraction, 1.0 - fraction, lessThan(node, vec2(0.0))), notEqual(abs(node - 0.5), vec2(0.5)));
        vec2 disc = vec2(cos(angle), sin(angle)) * (radius * sqrt((float(i) + 0.5) / float(PENUMBRA_TAPS)));
        ivec2 at = ivec2(floor(wide ? place + disc : (base + node + 0.5) * stride));
        float depth = texelFetch(shadow_maps, ivec3(clamp(at, ivec2(0), size - 1), layer), 0).x;
        float plane = wide ? s.z + dot(slope, vec2(at) + 0.5 - place) : s.z;
        lit += depth <= max(plane, 0.0) ? (wide ? 1.0 : weight.x * weight.y) : 0.0;
        angle += GOLDEN_ANGLE;
    }
    return partly ? lit / (wide ? float(PENUMBRA_TAPS) : 9.0) : (blocked > 0.0 ? 0.0 : 1.0);
}

// Fraction of a sun that the macrosurface sees.
float sun_visibility(const int sun, const vec3 position, const vec3 mesonormal, const vec3 macronormal, const float width) {
    Receiver r = Receiver(position, mesonormal, macronormal, lighting.sun_direction[sun].xyz, lighting.environment.z);
    // The map is as deep as it is wide.
    float spread = lighting.sun_irradiance[sun].w * float(textureSize(shadow_maps, 0).x);
    return map_visibility(sun, r, width, spread, STEEPEST);
}

// Fraction of a point light that the macrosurface sees. Its map shows the sphere around all that casts shadows: nothing outside is shadowed.
float point_visibility(const int layer, const int point, const vec3 position, const vec3 mesonormal, const vec3 macronormal,
                       const float width) {
    vec3 towards = normalize(lighting.point_position[point].xyz - position);
    vec4 place = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    float texel = lighting.point_shadow[point].y * max(place.w, 1e-6);
    Receiver r = Receiver(position, mesonormal, macronormal, towards, texel);
    // A map is so many times as wide as it is far: a depth changes by that much less across it.
    float wide = lighting.point_shadow[point].y * float(textureSize(shadow_maps, 0).x);
    float steepest = STEEPEST * wide * place.z / max(place.w, 1e-6);
    float lit = map_visibility(layer, r, width, lighting.point_shadow[point].x, steepest);
    return place.w > 0.0 ? lit : 1.0;
}

#endif
