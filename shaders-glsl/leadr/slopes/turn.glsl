#ifndef LEADR_SLOPE_TURN_GLSL
#define LEADR_SLOPE_TURN_GLSL

#include "statistics.glsl"

// Slope statistics of a surface seen from another frame than its own, to first order about its mean normal, and their
// sum over surfaces. src/reflectance/slopes/turn.rs derives both.

// A part of a surface over a common plane.
struct SlopePart {
    vec2 mean;
    vec3 covariance;
    float area; // on the plane
};

// Mean and covariance in the frame `turn` leads to (its columns are the old axes there), of a part whose own plane has
// unit area. Normals that leave the new hemisphere are held above its horizon.
SlopePart turn_slopes(mat3 turn, vec2 mean, vec3 S) {
    vec3 n = turn * vec3(-mean, 1.0);
    float z = max(n.z, 0.1 * length(n));
    vec2 slope = -n.xy / z;
    // Derivatives of the new slope by the old one.
    vec2 u = (turn[0].xy + slope * turn[0].z) / z;
    vec2 v = (turn[1].xy + slope * turn[1].z) / z;
    return SlopePart(slope, map_second_moments(mat2(u, v), S), z);
}

// The union of two parts: moments add by area; written so that near means do not cancel.
SlopePart join_slopes(SlopePart a, SlopePart b) {
    float area = a.area + b.area;
    float t = area > 0.0 ? b.area / area : 0.0;
    vec2 d = b.mean - a.mean;
    vec3 spread = (t * (1.0 - t)) * vec3(d * d, d.x * d.y);
    return SlopePart(mix(a.mean, b.mean, t), mix(a.covariance, b.covariance, t) + spread, area);
}

#endif
