#ifndef LEADR_NORMAL_BLENDING_GLSL
#define LEADR_NORMAL_BLENDING_GLSL

// Blends a detail normal onto a base normal, both unit normals of normal maps with z > 0.
// crates/leadr-reflectance/src/slopes/normal_blending.rs describes each blend and the order to which it adds slopes.

// Normalises n; a zero vector becomes straight up.
vec3 blended_direction(const vec3 n) {
    float square = dot(n, n);
    return square > 1e-24 ? n / sqrt(square) : vec3(0.0, 0.0, 1.0);
}

// Blends by reoriented normal mapping, which applies to the detail the shortest rotation from z to the base (Barre-Brisebois
// and Hill 2012).
vec3 blend_reoriented(const vec3 base, const vec3 detail) {
    vec3 t = base + vec3(0.0, 0.0, 1.0);
    vec3 u = detail * vec3(-1.0, -1.0, 1.0);
    return blended_direction(t * (2.0 * dot(t, u) / max(dot(t, t), 1e-12)) - u);
}

// Blends by whiteout, which adds offsets and multiplies heights.
vec3 blend_whiteout(const vec3 base, const vec3 detail) {
    return blended_direction(vec3(base.xy + detail.xy, max(base.z, 0.0) * max(detail.z, 0.0)));
}

// Blends by UDN, which adds the detail's offsets to the base.
vec3 blend_udn(const vec3 base, const vec3 detail) {
    return blended_direction(vec3(base.xy + detail.xy, max(base.z, 0.0)));
}

// Adds the offsets, and computes z from unit length (Chan 2018, Algorithm 4). Longer offsets are clamped to 1.
vec3 blend_xy(const vec3 base, const vec3 detail) {
    vec2 xy = base.xy + detail.xy;
    float square = dot(xy, xy);
    return square >= 1.0 ? vec3(xy / sqrt(square), 0.0) : vec3(xy, sqrt(1.0 - square));
}

// Adds the slopes, as for relief on relief.
vec3 blend_partial_derivatives(const vec3 base, const vec3 detail) {
    float b = max(base.z, 0.0);
    float d = max(detail.z, 0.0);
    return blended_direction(vec3(base.xy * d + detail.xy * b, b * d));
}

// Returns the mean of both normals, half as steep as either.
vec3 blend_linear(const vec3 base, const vec3 detail) {
    return blended_direction(base + detail);
}

#endif
