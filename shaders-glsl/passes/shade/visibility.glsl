// Visibility of lights from a facet past the relief. The test uses the depth maps of the lights. If the casters are a height field, the
// test marches over the field instead.
#ifndef LEADR_SHADE_VISIBILITY
#define LEADR_SHADE_VISIBILITY
#include "../constants.glsl"

// These options are constants, because lavapipe recompiles a shader for every draw if branches depend only on uniforms.
layout(constant_id = 80) const bool HEIGHT_FIELD = false; // whether the casters are a height field

const float MAP_BIAS = 1.0;      // offset towards the light before the comparison, in texels of its map
const float FIELD_BIAS = 0.06;   // offset along the normal before the march, in texels of the field
const float FIELD_REACH = 0.5;   // span of height differences, in texels of the field: about a sixth of a relief texel
const int FIELD_STEPS = 1024;    // largest number of steps of a march, which leaves the relief much earlier
const float FIELD_STRIDE = 2.0;  // longest step in texels, less than a relief texel
const float FIELD_GROWTH = 0.01; // growth of the steps, in texels per step

struct Light {
    mat4 texture_from_world; // world space to [0,1] texture coordinates and reversed depth of the light's map
    mat4 world_from_texture;
    vec4 position; // xyz: direction towards the light, or its position; w: 1 for a point light
    vec4 power; // rgb: irradiance on a plane facing the light, or intensity; w: LIGHT_ constant
    vec4 falloff; // falloff of a point light (point_reach)
    vec4 range;   // x: 1 / range^2, or 0
    vec4 map;   // layer; world size of a texel (for a point light, at distance 1); density of the draw; 1 if the light has a map
};

layout(std140) uniform Lighting {
    mat4 field_from_world; // world space to [0,1] texture coordinates and reversed depth of the height field's map
    vec4 rays[3];          // see surface_at
    vec4 camera_position;  // xyz: position; w: radiance of an emission of 1
    vec4 viewport;         // width, height, face size of the environment's cube
    vec4 air;              // rgb: extinction per metre
    vec4 field;            // of a height field: texel size in metres, depth of the highest point, texels a side
    ivec4 counts;          // lights; those drawn from the environment; face size of its texels; sample
    uvec4 seed;            // x
    Light lights[MAX_RELIEF_LIGHTS];
} lighting;

uniform sampler2DArray depth_maps;

// Whether a light with a map reaches a facet. The map holds depths at texel centres, so the facet's plane is evaluated at texel centres as
// well, not at the pixel's hit point. A facet therefore never shadows itself, at any angle.
bool reaches_by_map(const Light light, const vec3 position, const vec3 normal, const vec3 towards) {
    if (light.map.w < 0.5) {
        return true;
    }
    float texel = light.map.y * (light.position.w > 0.5 ? distance(light.position.xyz, position) : 1.0);
    vec3 lifted = position + towards * (texel * MAP_BIAS);
    vec4 s = light.texture_from_world * vec4(lifted, 1.0);
    vec4 further = light.texture_from_world * vec4(position + towards * (8.0 * texel), 1.0);
    s.xyz /= s.w;
    if (s.w <= 0.0 || any(lessThan(s.xy, vec2(0.0))) || any(greaterThanEqual(s.xy, vec2(1.0)))) {
        return true;
    }
    vec2 size = vec2(textureSize(depth_maps, 0).xy);
    ivec2 at = ivec2(s.xy * size);
    vec2 offset = (vec2(at) + 0.5) / size - s.xy;
    vec4 plane = vec4(normal, -dot(normal, lifted)) * light.world_from_texture;
    float limit = abs(further.z / further.w - s.z); // a plane seen edge-on can have any depth
    float slope = abs(plane.z) > 1e-20 ? -dot(plane.xy, offset) / plane.z : 0.0;
    return texelFetch(depth_maps, ivec3(at, int(light.map.x)), 0).x <= s.z + clamp(slope, -limit, limit);
}

// Returns the depth of the field, interpolated linearly between the centres of its texels. The depth is exact inside a triangle.
float field_depth(const vec2 st) {
    vec2 texel = st * lighting.field.z - 0.5;
    vec2 f = fract(texel);
    vec4 d = textureGather(depth_maps, vec3((floor(texel) + 1.0) / lighting.field.z, 0.0), 0);
    return mix(mix(d.w, d.z, f.x), mix(d.x, d.y, f.x), f.y);
}

// Returns the normal of the height field's triangle above or below a point, in world space.
vec3 field_normal(const vec3 position) {
    mat3 to_map = mat3(lighting.field_from_world);
    vec3 x = vec3(to_map[0].x, to_map[1].x, to_map[2].x), y = vec3(to_map[0].y, to_map[1].y, to_map[2].y);
    vec3 z = vec3(to_map[0].z, to_map[1].z, to_map[2].z);
    vec2 st = (lighting.field_from_world * vec4(position, 1.0)).xy;
    float h = FIELD_REACH / lighting.field.z;
    vec2 rise = vec2(field_depth(st + vec2(h, 0.0)) - field_depth(st - vec2(h, 0.0)),
                     field_depth(st + vec2(0.0, h)) - field_depth(st - vec2(0.0, h))) / (2.0 * h);
    return normalize(z - rise.x * x - rise.y * y);
}

// Whether the height field leaves a direction unobstructed within `reach` metres.
bool reaches_over_field(const vec3 position, const vec3 normal, const vec3 towards, const float reach) {
    vec3 start = (lighting.field_from_world * vec4(position + normal * (FIELD_BIAS * lighting.field.x), 1.0)).xyz;
    vec3 along = mat3(lighting.field_from_world) * towards; // per metre
    float texel = 1.0 / max(max(abs(along.x), abs(along.y)) * lighting.field.z, 1e-9);
    float t = 0.0;
    for (int i = 0; i < FIELD_STEPS; ++i) {
        t += texel * min(0.5 + FIELD_GROWTH * float(i), FIELD_STRIDE);
        vec3 at = start + t * along;
        bool gone = at.z > lighting.field.y || t > reach || any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0)));
        if (gone) {
            return true;
        }
        if (field_depth(at.xy) > at.z) {
            return false;
        }
    }
    return true;
}

#endif
