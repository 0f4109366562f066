// The lights' uniform block, and the fraction of each light that reaches a point. A sun is a directional light. The frame's own sun comes
// first, and the suns of its panorama follow.
#ifndef LEADR_SHADE_SUN
#define LEADR_SHADE_SUN
#include "../constants.glsl"
#include "leadr/frame.glsl"

layout(set = 1, std140) uniform Lighting {
    vec4 rays[3];                 // see surface_at
    mat4 shadow_from_world[MAX_SHADOW_MAPS]; // for each light in order: world space to [0,1] texture coordinates and depth
    vec4 camera_position;         // xyz: position; w: radiance of an emission of 1
    vec4 sun_direction[MAX_SUNS]; // xyz: direction toward the sun; w: variance of its directions
    vec4 sun_irradiance[MAX_SUNS]; // rgb: irradiance on a plane facing the sun; w: tangent of its angular radius
    vec4 lamp_shadow[MAX_LAMP_MAPS]; // x: texels of penumbra per unit of depth; y: size of a map texel at distance 1
    vec4 viewport;                // width, height, pixels per pixel of the final image
    vec4 environment;             // x: cube face size, z: shadow texel in world units, w: tangent of the lowest elevation behind all
    vec4 air;                     // rgb: extinction per metre
    uvec4 draws;                  // sample, seed, number of lamps
} lighting;

layout(set = 1) uniform sampler2DArray shadow_maps; // one layer per light: suns, then lamps

// Returns the width of a pixel of this image at a point, in world units.
float pixel_width(const vec3 position) {
    return distance(position, lighting.camera_position.xyz) * 2.0 * length(lighting.rays[0].xyz) / lighting.viewport.x;
}

// Returns the width over which an edge sample averages the shadow map, in pixels of the final image. This width exceeds the width of the
// sample. The geometry of a sample resolves finer bumps than the map, of up to half the relief (in metres), and these bumps must not shadow
// themselves.
float edge_shadow_width(const vec3 position, const float relief) {
    return clamp(0.5 * relief / max(pixel_width(position) * lighting.viewport.z, 1e-9), 0.25, 1.0);
}

// The number of taps of the blocker search, and of a penumbra.
const int SEARCH_TAPS = 16;
const int PENUMBRA_TAPS = 32;
const float GOLDEN_ANGLE = 2.39996323; // radians
// Up to this width, 4 x 4 comparisons, whose weights form a box of 3 texels, approximate the penumbra.
const float NARROW = 2.0;
// The largest penumbra, in texels per side. A larger penumbra would need more taps for its area.
const float WIDEST = 48.0;
// The steepest slope of the receiver plane that is used, as a tangent. Light at more grazing angles adds almost nothing.
const float STEEPEST = 4.0;

// Returns the position of a point on a shadow map, [0,1], and its depth.
vec3 on_map(const int layer, const vec3 position) {
    vec4 s = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    return s.xyz / max(s.w, 1e-6);
}

// The parameters of the receiver for a shadow map.
struct Receiver {
    vec3 position;
    vec3 mesonormal;  // normal with the bumps under the pixel
    vec3 macronormal; // normal without the bumps
    vec3 towards;     // unit vector to the light
    float texel;      // size of a map texel at the receiver, in world units
};

// Returns the gradient of depth over the map on the receiver's plane. Depth is linear in parallel and in perspective views. s is the
// position of the receiver on the map.
vec2 plane_on_map(const int layer, const Receiver r, const vec3 s, const float steepest) {
    Frame along = frame_about(r.macronormal);
    vec3 a = on_map(layer, r.position + r.texel * along.x) - s, b = on_map(layer, r.position + r.texel * along.y) - s;
    float det = a.x * b.y - a.y * b.x;
    vec2 slope = vec2(a.z * b.y - a.y * b.z, a.x * b.z - a.z * b.x) / (abs(det) < 1e-20 ? 1e-20 : det);
    return slope * min(1.0, steepest / max(length(slope), 1e-20));
}

// Returns the fraction of a light that reaches the macrosurface according to the light's shadow map. The penumbra grows with the distance
// of the blocker (percentage-closer soft shadows, Fernando 2005). width is the smallest width of the filter, in pixels of this image.
// spread is the width of the penumbra, in texels per side, per unit of depth between blocker and receiver. steepest is STEEPEST in units of
// the map.
//
// The filter is at least as wide as a map texel and as a pixel, and has 4 x 4 comparisons with bilinear weights. The slope statistics
// include the shadows of smaller bumps, so the point is moved above these bumps. For a wide penumbra, the point is moved toward the light
// instead, by a fraction of the penumbra's width. This movement does not shift the shadow's edges. The blockers of a wide penumbra are far
// away, so no contact shadow is lost.
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
    // Taps are denser at the centre to catch the thin ends of touching shadows. The long shadows of a low sun reach beyond the depth of the
    // map, where no casters exist. Beyond the map the depth is 0, and the receiver's depth is clamped to 0.
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
    // One loop with a non-uniform bound handles both cases. With two loops or an `if`, drivers without divergent branches (lavapipe) would
    // run all bodies at every pixel.
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

// Returns the fraction of a sun that reaches the macrosurface.
float sun_visibility(const int sun, const vec3 position, const vec3 mesonormal, const vec3 macronormal, const float width) {
    Receiver r = Receiver(position, mesonormal, macronormal, lighting.sun_direction[sun].xyz, lighting.environment.z);
    // The depth range of the map equals its width.
    float spread = lighting.sun_irradiance[sun].w * float(textureSize(shadow_maps, 0).x);
    return map_visibility(sun, r, width, spread, STEEPEST);
}

#endif
