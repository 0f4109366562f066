// A triangle whose relief is projected along the axes of its rest pose (triplanar.glsl). Positions on it are barycentric weights, as in
// triangle.glsl.
#ifndef LEADR_GEOMETRY_REST_TRIANGLE
#define LEADR_GEOMETRY_REST_TRIANGLE
#include "../triplanar.glsl"
#include "patch.glsl"

struct RestTriangle {
    vec3 first;      // rest position of the first corner, in repeats
    mat2x3 by_uv; // derivatives of the rest position
    vec3 normals[3];
};

// Unpacks an octahedral normal with 12 bits per coordinate. All 24 bits are held exactly by a float
// (crates/leadr-render/src/surfaces/object.rs).
vec3 unpack_rest_normal(const float code) {
    vec2 octahedron = vec2(floor(code / 4096.0), mod(code, 4096.0)) / 4095.0 * 2.0 - 1.0;
    vec3 normal = vec3(octahedron, 1.0 - abs(octahedron.x) - abs(octahedron.y));
    vec2 folded = (1.0 - abs(octahedron.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(octahedron, vec2(0.0)));
    normal.xy = normal.z < 0.0 ? folded : normal.xy;
    return normalize(normal);
}

RestTriangle rest_triangle(const PatchData data) {
    vec4 a = data.mapping[0], b = data.mapping[1], c = data.mapping[2];
    return RestTriangle(a.xyz, mat2x3(b.xyz - a.xyz, c.xyz - a.xyz),
                        vec3[3](unpack_rest_normal(a.w), unpack_rest_normal(b.w), unpack_rest_normal(c.w)));
}

vec3 rest_normal(const RestTriangle rest, const vec2 patch_uv) {
    vec3 normal = rest.normals[0] + mat2x3(rest.normals[1] - rest.normals[0], rest.normals[2] - rest.normals[0]) * patch_uv;
    return normal * inversesqrt(max(dot(normal, normal), 1e-12));
}

// Returns the derivatives of relief_weights by position.
mat2x3 relief_weights_by_uv(const RestTriangle rest, const vec2 patch_uv, const vec3 normal) {
    mat2x3 normal_change = mat2x3(rest.normals[1] - rest.normals[0], rest.normals[2] - rest.normals[0]);
    vec3 blend = rest.normals[0] + normal_change * patch_uv;
    normal_change = (normal_change - outerProduct(normal, normal * normal_change)) * inversesqrt(max(dot(blend, blend), 1e-12));
    vec3 facing = max(abs(normal) - 0.5, 0.0);
    vec3 rate = 2.0 * facing * sign(normal), weights = facing * facing;
    mat2x3 change = mat2x3(rate * normal_change[0], rate * normal_change[1]);
    float per_root = inversesqrt(max(dot(weights, weights), 1e-20));
    weights *= per_root;
    return (change - outerProduct(weights, weights * change)) * per_root;
}

// Returns the mean of a map, which is its last mip level.
float mean_height(sampler2D heights) {
    return textureLod(heights, vec2(0.5), float(textureQueryLevels(heights) - 1)).x;
}

// Returns a position projected along an axis. seen_by_uv returns the derivatives.
vec2 seen_at(const RestTriangle rest, const int axis, const vec2 patch_uv, const vec3 normal) {
    return seen_along(axis, rest.first + rest.by_uv * patch_uv, normal) + TRIPLANAR_SHIFTS[axis];
}

mat2 seen_by_uv(const RestTriangle rest, const int axis, const vec3 normal) {
    return mat2(seen_along(axis, rest.by_uv[0], normal), seen_along(axis, rest.by_uv[1], normal));
}

// Returns the height at a position, relative to the mean of the map.
float triplanar_height(const RestTriangle rest, const vec2 patch_uv, sampler2D heights, const float lod) {
    vec3 normal = rest_normal(rest, patch_uv);
    vec3 weights = relief_weights(normal);
    float mean = mean_height(heights);
    float height = mean;
    for (int axis = 0; axis < 3; ++axis) {
        if (weights[axis] > 0.0) {
            height += weights[axis] * (textureLod(heights, seen_at(rest, axis, patch_uv, normal), lod).x - mean);
        }
    }
    return height;
}

#endif
