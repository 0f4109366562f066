// A triangle whose relief is seen along the axes where it is at rest (triplanar.glsl). Places are as in triangle.glsl.
#ifndef LEADR_GEOMETRY_REST_TRIANGLE
#define LEADR_GEOMETRY_REST_TRIANGLE
#include "../triplanar.glsl"
#include "patch.glsl"

struct RestTriangle {
    vec3 first;      // corner, repeats
    mat2x3 by_place; // derivatives of the place at rest
    vec3 normals[3];
};

// Twelve bits for each coordinate of an octahedron, in a float that holds all 24 (crates/leadr-render/src/surfaces/object.rs).
vec3 unpack_rest_normal(const float code) {
    vec2 octahedron = vec2(floor(code / 4096.0), mod(code, 4096.0)) / 4095.0 * 2.0 - 1.0;
    vec3 normal = vec3(octahedron, 1.0 - abs(octahedron.x) - abs(octahedron.y));
    vec2 folded = (1.0 - abs(octahedron.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(octahedron, vec2(0.0)));
    normal.xy = normal.z < 0.0 ? folded : normal.xy;
    return normalize(normal);
}

RestTriangle rest_triangle(const PatchData data) {
    vec4 a = data.texture_place[0], b = data.texture_place[1], c = data.texture_place[2];
    return RestTriangle(a.xyz, mat2x3(b.xyz - a.xyz, c.xyz - a.xyz),
                        vec3[3](unpack_rest_normal(a.w), unpack_rest_normal(b.w), unpack_rest_normal(c.w)));
}

vec3 rest_normal(const RestTriangle rest, const vec2 place) {
    vec3 normal = rest.normals[0] + mat2x3(rest.normals[1] - rest.normals[0], rest.normals[2] - rest.normals[0]) * place;
    return normal * inversesqrt(max(dot(normal, normal), 1e-12));
}

// Derivatives of relief_weights by the place.
mat2x3 relief_weights_by_place(const RestTriangle rest, const vec2 place, const vec3 normal) {
    mat2x3 turn = mat2x3(rest.normals[1] - rest.normals[0], rest.normals[2] - rest.normals[0]);
    vec3 blend = rest.normals[0] + turn * place;
    turn = (turn - outerProduct(normal, normal * turn)) * inversesqrt(max(dot(blend, blend), 1e-12));
    vec3 facing = max(abs(normal) - 0.5, 0.0);
    vec3 rate = 2.0 * facing * sign(normal), weights = facing * facing;
    mat2x3 change = mat2x3(rate * turn[0], rate * turn[1]);
    float per_root = inversesqrt(max(dot(weights, weights), 1e-20));
    weights *= per_root;
    return (change - outerProduct(weights, weights * change)) * per_root;
}

// The mean of a map, in its last level.
float mean_height(sampler2D heights) {
    return textureLod(heights, vec2(0.5), float(textureQueryLevels(heights) - 1)).x;
}

// Where a place is seen along an axis, and the derivatives of that.
vec2 seen_at(const RestTriangle rest, const int axis, const vec2 place, const vec3 normal) {
    return seen_along(axis, rest.first + rest.by_place * place, normal) + TRIPLANAR_SHIFTS[axis];
}

mat2 seen_by_place(const RestTriangle rest, const int axis, const vec3 normal) {
    return mat2(seen_along(axis, rest.by_place[0], normal), seen_along(axis, rest.by_place[1], normal));
}

// The height at a place, about the mean of the map.
float triplanar_height(const RestTriangle rest, const vec2 place, sampler2D heights, const float lod) {
    vec3 normal = rest_normal(rest, place);
    vec3 weights = relief_weights(normal);
    float mean = mean_height(heights);
    float height = mean;
    for (int axis = 0; axis < 3; ++axis) {
        if (weights[axis] > 0.0) {
            height += weights[axis] * (textureLod(heights, seen_at(rest, axis, place, normal), lod).x - mean);
        }
    }
    return height;
}

#endif
