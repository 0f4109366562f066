// Occlusion by large shapes (crates/leadr-render/src/light/sky_visibility.rs), and the light of what they hide.
#ifndef LEADR_SHADE_SKY_VISIBILITY
#define LEADR_SHADE_SKY_VISIBILITY
#include "../constants.glsl"
#include "settings.glsl"
#include "leadr/masking/occlusion.glsl"

// Fraction of its light that hidden geometry adds to specular reflection: objects and ground reflect about a fifth.
const float HIDDEN_ALBEDO = 0.2;

layout(set = 1, std430) readonly buffer SkyVisibility {
    vec4 sky_corner; // xyz: lowest corner of the volume, its floor, metres
    vec4 sky_rates;  // xy: nodes per metre across; zw: one over the reach of the layers above and below the floor
    vec2 sky_across; // number of nodes
    uint sky_nodes[];
};

vec4 sky_node(const uvec3 at, const uvec2 size) {
    return unpackSnorm4x8(sky_nodes[(at.z * size.y + at.y) * size.x + at.x]);
}

// Visibility of the surroundings at a point of the macrosurface. w: visible fraction of a constant environment, cosine-weighted
// about the normal; xyz: its increase towards a direction, without the part along the normal, which is the surface's own
// horizon.
//
// The normal is that of the macrosurface. The half-space behind it is hidden from its bumps in any case; the slope statistics
// account for that. The lookup is one node away from the surface to avoid self-occlusion; nodes are dense where objects meet
// the ground.
vec4 sky_seen(const vec3 position, const vec3 normal) {
    const float below = float(SKY_LAYERS_BELOW), above = float(SKY_LAYERS - 1u - SKY_LAYERS_BELOW);
    float up = position.z - sky_corner.z;
    float layer = sqrt(abs(up) * (up < 0.0 ? sky_rates.w : sky_rates.z));
    vec3 at = vec3((position.xy - sky_corner.xy) * sky_rates.xy, below + (up < 0.0 ? -layer * below : layer * above)) + normal;
    vec3 last = vec3(sky_across, float(SKY_LAYERS)) - 1.0;
    // Fades out at the rim.
    vec3 beside = clamp(min(at, last - at) / vec3(0.2 * last.xy, 1.5), 0.0, 1.0);
    float weight = min(min(beside.x, beside.y), beside.z);
    at = clamp(at, vec3(0.0), last - 1e-3);
    uvec3 base = uvec3(at);
    uvec2 size = uvec2(sky_across);
    vec3 part = at - vec3(base);
    vec4 seen[2];
    for (uint k = 0u; k < 2u; ++k) {
        uvec3 first = base + uvec3(0u, 0u, k);
        vec4 near = mix(sky_node(first, size), sky_node(first + uvec3(1u, 0u, 0u), size), part.x);
        vec4 far = mix(sky_node(first + uvec3(0u, 1u, 0u), size), sky_node(first + uvec3(1u, 1u, 0u), size), part.x);
        seen[k] = mix(near, far, part.y);
    }
    vec4 node = mix(seen[0], seen[1], part.z);
    vec3 b = 1.5 * node.xyz;
    float along = dot(b, normal);
    float share = clamp(0.5 + 0.5 * node.w + along * (2.0 / 3.0), 0.0, 1.0);
    return mix(vec4(0.0, 0.0, 0.0, 1.0), vec4(b - along * normal, share), weight);
}

// Factor on the environment's diffuse light; `known` is the fraction visible past occluders that the surface itself stores.
// Both contain the same large shapes. Hidden directions are as bright as the point itself: the ground lights objects and they
// light the ground (Chan 2018, eq. 49).
vec3 sky_on_diffuse(const vec4 sky, const float known, const vec3 albedo) {
    return known * interreflected_visibility(min(1.0, sky.w / max(known, 1e-3)), albedo);
}

// The factor for specular reflection towards a world direction. It differs from 1 only where something is hidden: geometry
// beyond the rim of a plate lies below all its reflected directions.
float sky_in_specular(const vec4 sky, const float known, const vec3 towards) {
    float seen = clamp(sky.w + min(1.0, 6.0 * (1.0 - sky.w)) * dot(sky.xyz, towards), 0.0, 1.0);
    return known * mix(HIDDEN_ALBEDO, 1.0, min(1.0, seen / max(known, 1e-3)));
}

#endif
