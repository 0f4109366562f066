// Triplanar projection of a texture onto a surface without texture coordinates. The texture is projected from outside along the three axes
// of the rest pose, upright (z up), and blended by the normal. crates/leadr-render/src/surfaces/triplanar.rs has the same functions.
#ifndef LEADR_TRIPLANAR
#define LEADR_TRIPLANAR

// The offsets of the projections, in repeats. The offsets make the projections differ where they meet. Courses of bricks still continue
// around a corner.
const vec2 TRIPLANAR_SHIFTS[3] = vec2[](vec2(0.0), vec2(0.37, 0.0), vec2(0.71));

// Returns the weight of each view for a unit normal. The weights are not normalised, but their sum is above 0.
vec3 triplanar_weights(const vec3 normal) {
    vec3 weights = max(abs(normal) - 0.5, 0.0);
    return weights * weights;
}

// Returns the weights for a relief. The squares sum to one, which preserves the variance of the relief.
vec3 relief_weights(const vec3 normal) {
    vec3 weights = triplanar_weights(normal);
    return weights * inversesqrt(max(dot(weights, weights), 1e-20));
}

// Returns a vector, in repeats, as seen along an axis (0 to 2) from the side that the normal faces.
vec2 seen_along(const int axis, const vec3 v, const vec3 normal) {
    vec2 seen = axis == 0 ? vec2(v.y, -v.z) : (axis == 1 ? vec2(-v.x, -v.z) : vec2(v.x, -v.y));
    return vec2(normal[axis] < 0.0 ? -seen.x : seen.x, seen.y);
}

#endif
