#ifndef LEADR_SLOPE_MAP_GLSL
#define LEADR_SLOPE_MAP_GLSL

#include "statistics.glsl"

// Converts height derivatives by texture coordinate to slopes in an orthonormal frame (LEADR eq. 12, for any parametrisation). A point of
// the surface is X + h N. T = d(X)/ds + h d(N)/ds is the derivative of the offset macrosurface. In a frame with z = N, the normal (-slope,
// 1) is orthogonal to T + h_s N exactly when slope . T.xy = h_s + T.z.

// The map slope = linear * (h_s, h_t) + offset. The columns of `linear` are separate vectors, because naga accepts no 2 x 2 matrix in a
// struct.
struct SlopeMap {
    vec2 linear_s;
    vec2 linear_t;
    vec2 offset; // slope of the offset macrosurface, which may be tilted relative to N
};

// Computes the map from ts and tt, the derivatives of the offset macrosurface by s and t. x, y and z are an orthonormal frame, with z the
// displacement direction. Where the surface is edge-on to z, the determinant is clamped to 1e-4 of the squared tangent lengths and keeps
// its sign, which is negative for mirrored charts. The slopes therefore stay finite.
SlopeMap slope_map(const vec3 ts, const vec3 tt, const vec3 x, const vec3 y, const vec3 z) {
    vec3 s = vec3(dot(ts, x), dot(ts, y), dot(ts, z));
    vec3 t = vec3(dot(tt, x), dot(tt, y), dot(tt, z));
    float det = s.x * t.y - s.y * t.x;
    float bound = max(1e-4 * (dot(s, s) + dot(t, t)), 1e-20);
    float inverse = (det < 0.0 ? -1.0 : 1.0) / max(abs(det), bound);
    mat2 linear = mat2(t.y, -t.x, -s.y, s.x) * inverse;
    return SlopeMap(linear[0], linear[1], linear * vec2(s.z, t.z));
}

// Returns the mean slope in the frame. The length of the slope is clamped to MAX_SLOPE. gradient is (E[h_s], E[h_t]).
vec2 map_mean_slope(const SlopeMap map, const vec2 gradient) {
    vec2 slope = clamp(mat2(map.linear_s, map.linear_t) * gradient + map.offset, -1e12, 1e12);
    return slope * min(1.0, LEADR_MAX_SLOPE * inversesqrt(max(dot(slope, slope), 1e-12)));
}

// Returns the covariance in the frame, linear S linear^T (LEADR eq. 12). The result is clamped by clamp_covariance.
vec3 map_covariance(const SlopeMap map, const vec3 S) {
    return clamp_covariance(map_second_moments(mat2(map.linear_s, map.linear_t), S));
}

#endif
