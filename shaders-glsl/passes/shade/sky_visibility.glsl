// Occlusion by large shapes (crates/leadr-render/src/light/sky_visibility.rs), and the light that these shapes reflect.
#ifndef LEADR_SHADE_SKY_VISIBILITY
#define LEADR_SHADE_SKY_VISIBILITY
#include "../constants.glsl"
#include "settings.glsl"
#include "leadr/masking/occlusion.glsl"

// The fraction of the environment's light that hidden geometry contributes to specular reflection. Objects and ground reflect about a
// fifth.
const float HIDDEN_ALBEDO = 0.2;

layout(set = 1, std430) readonly buffer SkyVisibility {
    vec4 sky_corner; // xyz: lowest corner of the volume; its floor; in metres
    vec4 sky_rates;  // xy: nodes per metre, horizontally; zw: one over the height range of the layers above and below the floor
    vec2 sky_across; // number of nodes
    uvec2 sky_nodes[];
};

vec4 sky_node(const uvec3 at, const uvec2 size) {
    uvec2 node = sky_nodes[(at.z * size.y + at.y) * size.x + at.x];
    return vec4(unpackSnorm2x16(node.x), unpackSnorm2x16(node.y));
}

// Returns the visibility of the surroundings at a point of the macrosurface. w is the visible fraction of a constant environment,
// cosine-weighted about the normal. xyz is the increase of this fraction towards a direction, without the part along the normal, which is
// due to the surface's own horizon.
//
// The normal is the normal of the macrosurface. The macrosurface hides the half-space behind it from its bumps, and the slope statistics
// account for this occlusion. The lookup is one node away from the surface to avoid self-occlusion. Nodes are dense where objects meet the
// ground.
vec4 sky_seen(const vec3 position, const vec3 normal) {
    const float below = float(SKY_LAYERS_BELOW), above = float(SKY_LAYERS - 1u - SKY_LAYERS_BELOW);
    float up = position.z - sky_corner.z;
    float layer = sqrt(abs(up) * (up < 0.0 ? sky_rates.w : sky_rates.z));
    vec3 at = vec3((position.xy - sky_corner.xy) * sky_rates.xy, below + (up < 0.0 ? -layer * below : layer * above)) + normal;
    vec3 last = vec3(sky_across, float(SKY_LAYERS)) - 1.0;
    // The occlusion fades out at the rim of the volume.
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

// Returns the factor on the environment's diffuse light. `known` is the visible fraction according to the occlusion that the surface itself
// stores. Both `sky` and `known` include the same large shapes. Hidden directions are as bright as the point itself, since objects and
// ground illuminate each other (Chan 2018, eq. 49).
vec3 sky_on_diffuse(const vec4 sky, const float known, const vec3 albedo) {
    return known * interreflected_visibility(min(1.0, sky.w / max(known, 1e-3)), albedo);
}

// Returns the factor on specular reflection towards a world direction. The factor differs from 1 only where something is hidden. Geometry
// beyond the rim of a plate hides nothing, because it lies below all directions that the plate reflects.
float sky_in_specular(const vec4 sky, const float known, const vec3 towards) {
    float seen = clamp(sky.w + min(1.0, 6.0 * (1.0 - sky.w)) * dot(sky.xyz, towards), 0.0, 1.0);
    return known * mix(HIDDEN_ALBEDO, 1.0, min(1.0, seen / max(known, 1e-3)));
}

#endif
