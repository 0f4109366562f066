// A texture without coordinates: seen from outside along the three axes, upright (z up), where the surface is at rest, and blended by
// the normal. The same as crates/leadr-render/src/surfaces/triplanar.rs.
#ifndef LEADR_TRIPLANAR
#define LEADR_TRIPLANAR

// By how many repeats the views are moved apart, so that they do not look alike where they meet. Courses of bricks go on round a corner.
const vec2 TRIPLANAR_SHIFTS[3] = vec2[](vec2(0.0), vec2(0.37, 0.0), vec2(0.71));

// How much each view counts, for a unit normal; they sum to anything above 0.
vec3 triplanar_weights(const vec3 normal) {
    vec3 weights = max(abs(normal) - 0.5, 0.0);
    return weights * weights;
}

// The same of a relief: the squares sum to one, so that it keeps its variance.
vec3 relief_weights(const vec3 normal) {
    vec3 weights = triplanar_weights(normal);
    return weights * inversesqrt(max(dot(weights, weights), 1e-20));
}

// A vector in repeats as it is seen along an axis (0 to 2) from the side that the normal faces.
vec2 seen_along(const int axis, const vec3 v, const vec3 normal) {
    vec2 seen = axis == 0 ? vec2(v.y, -v.z) : (axis == 1 ? vec2(-v.x, -v.z) : vec2(v.x, -v.y));
    return vec2(normal[axis] < 0.0 ? -seen.x : seen.x, seen.y);
}

#endif
