// Triplanar projection: a texture without coordinates, projected from outside along the three axes of the rest pose, upright (z
// up), and blended by the normal. Matches crates/leadr-render/src/surfaces/triplanar.rs.
#ifndef LEADR_TRIPLANAR
#define LEADR_TRIPLANAR

// Offsets of the views in repeats, so that they differ where they meet. Courses of bricks continue around a corner.
const vec2 TRIPLANAR_SHIFTS[3] = vec2[](vec2(0.0), vec2(0.37, 0.0), vec2(0.71));

// Weight of each view for a unit normal, not normalised; their sum is above 0.
vec3 triplanar_weights(const vec3 normal) {
    vec3 weights = max(abs(normal) - 0.5, 0.0);
    return weights * weights;
}

// Weights for a relief: the squares sum to one, which preserves its variance.
vec3 relief_weights(const vec3 normal) {
    vec3 weights = triplanar_weights(normal);
    return weights * inversesqrt(max(dot(weights, weights), 1e-20));
}

// A vector in repeats, projected along an axis (0 to 2) from the side that the normal faces.
vec2 seen_along(const int axis, const vec3 v, const vec3 normal) {
    vec2 seen = axis == 0 ? vec2(v.y, -v.z) : (axis == 1 ? vec2(-v.x, -v.z) : vec2(v.x, -v.y));
    return vec2(normal[axis] < 0.0 ? -seen.x : seen.x, seen.y);
}

#endif
