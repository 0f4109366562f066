#ifndef LEADR_NORMAL_BLENDING_GLSL
#define LEADR_NORMAL_BLENDING_GLSL

// Blends a detail normal onto a base normal, both unit normals of normal maps with z > 0.
// crates/leadr-reflectance/src/slopes/normal_blending.rs describes each blend and how closely it approximates adding the slopes.

// Normalises n. A zero vector becomes (0, 0, 1).
vec3 blended_direction(const vec3 n) {
    float square = dot(n, n);
    return square > 1e-24 ? n / sqrt(square) : vec3(0.0, 0.0, 1.0);
}

// Blends by reoriented normal mapping: applies the shortest rotation from z to the base to the detail (Barre-Brisebois and Hill 2012).
vec3 blend_reoriented(const vec3 base, const vec3 detail) {
    vec3 t = base + vec3(0.0, 0.0, 1.0);
    vec3 u = detail * vec3(-1.0, -1.0, 1.0);
    return blended_direction(t * (2.0 * dot(t, u) / max(dot(t, t), 1e-12)) - u);
}

// Blends by whiteout: adds the xy offsets and multiplies z.
vec3 blend_whiteout(const vec3 base, const vec3 detail) {
    return blended_direction(vec3(base.xy + detail.xy, max(base.z, 0.0) * max(detail.z, 0.0)));
}

// Blends by UDN: adds the xy offsets of the detail to the base.
vec3 blend_udn(const vec3 base, const vec3 detail) {
    return blended_direction(vec3(base.xy + detail.xy, max(base.z, 0.0)));
}

// Adds the xy offsets, and computes z for unit length (Chan 2018, Algorithm 4). A sum longer than 1 is clamped to 1.
vec3 blend_xy(const vec3 base, const vec3 detail) {
    vec2 xy = base.xy + detail.xy;
    float square = dot(xy, xy);
    return square >= 1.0 ? vec3(xy / sqrt(square), 0.0) : vec3(xy, sqrt(1.0 - square));
}

// Adds the slopes, which is correct for a relief on a relief.
vec3 blend_partial_derivatives(const vec3 base, const vec3 detail) {
    float b = max(base.z, 0.0);
    float d = max(detail.z, 0.0);
    return blended_direction(vec3(base.xy * d + detail.xy * b, b * d));
}

// Returns the normalised mean of both normals, which is only half as steep as the sum of their slopes.
vec3 blend_linear(const vec3 base, const vec3 detail) {
    return blended_direction(base + detail);
}

#endif
