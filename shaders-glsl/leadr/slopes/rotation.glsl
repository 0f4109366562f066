#ifndef LEADR_SLOPE_ROTATION_GLSL
#define LEADR_SLOPE_ROTATION_GLSL

#include "statistics.glsl"

// Converts slope statistics to another frame, to first order about the mean normal, and combines the statistics of several surfaces.
// crates/leadr-reflectance/src/slopes/rotation.rs has the derivations.

// One part of a surface, with an area projected onto a plane that all parts share.
struct SlopePart {
    vec2 mean;
    vec3 covariance;
    float area; // area projected onto the plane
};

// Returns the mean and covariance in a new frame. The part has unit area on its own plane. The columns of `rotation` are the old axes in
// the new frame. Normals that leave the new hemisphere are clamped above its horizon.
SlopePart rotate_slopes(const mat3 rotation, const vec2 mean, const vec3 S) {
    vec3 n = rotation * vec3(-mean, 1.0);
    float z = max(n.z, 0.1 * length(n));
    vec2 slope = -n.xy / z;
    // u and v are the derivatives of the new slope with respect to the old slope.
    vec2 u = (rotation[0].xy + slope * rotation[0].z) / z;
    vec2 v = (rotation[1].xy + slope * rotation[1].z) / z;
    return SlopePart(slope, map_second_moments(mat2(u, v), S), z);
}

// Returns the union of two parts. The moments of the parts add in proportion to area, in a form without cancellation between similar means.
SlopePart join_slopes(const SlopePart a, const SlopePart b) {
    float area = a.area + b.area;
    float t = area > 0.0 ? b.area / area : 0.0;
    vec2 d = b.mean - a.mean;
    vec3 spread = (t * (1.0 - t)) * vec3(d * d, d.x * d.y);
    return SlopePart(mix(a.mean, b.mean, t), mix(a.covariance, b.covariance, t) + spread, area);
}

#endif
