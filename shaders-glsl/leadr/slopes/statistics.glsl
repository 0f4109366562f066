#ifndef LEADR_SLOPE_STATISTICS_GLSL
#define LEADR_SLOPE_STATISTICS_GLSL

#include "../constants.glsl"
#include "../fma.glsl"

// The mean and covariance of the slopes under a pixel. A covariance is stored as (s_xx, s_yy, s_xy).

// Returns the nearest covariance with variances in [0, largest] and |s_xy| <= MAX_CORRELATION sqrt(s_xx s_yy).
vec3 bounded_covariance(const vec3 S, const float largest) {
    vec2 v = clamp(S.xy, 0.0, largest);
    float c = LEADR_MAX_CORRELATION * sqrt(v.x * v.y);
    return vec3(v, clamp(S.z, -c, c));
}

// Returns the nearest usable covariance of slopes (rise over run), with variances up to MAX_SLOPE^2.
vec3 clamp_covariance(const vec3 S) {
    return bounded_covariance(S, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE);
}

// Returns the correlation coefficient, |r| <= MAX_CORRELATION. `sigma` has the standard deviations of both axes.
float slope_correlation(const vec2 sigma, const float sxy) {
    return clamp(sxy / max(sigma.x * sigma.y, 1e-18), -LEADR_MAX_CORRELATION, LEADR_MAX_CORRELATION);
}

// Returns the covariance from the filtered moments first = (E[x], E[y]), second = (E[xx], E[yy], E[xy]); LEADR eq. 9. The function works in
// any unit, for example heights per texture coordinate, where even a flat relief has large values. scale_height and map_covariance convert
// the result to slopes.
vec3 covariance_from_moments(const vec2 first, const vec3 second) {
    return bounded_covariance(vec3(fma(-first.x, first.x, second.x), fma(-first.y, first.y, second.y),
                                   fma(-first.x, first.y, second.z)), LEADR_MAX_GRADIENT_VARIANCE);
}

// Returns linear S linear^T, the second moments of slopes transformed by linear (LEADR eq. 12).
vec3 map_second_moments(const mat2 linear, const vec3 S) {
    vec2 u = vec2(linear[0].x, linear[1].x); // first row of linear
    vec2 v = vec2(linear[0].y, linear[1].y);
    vec2 su = vec2(S.x * u.x + S.z * u.y, S.z * u.x + S.y * u.y);
    vec2 sv = vec2(S.x * v.x + S.z * v.y, S.z * v.x + S.y * v.y);
    return vec3(dot(u, su), dot(v, sv), dot(u, sv));
}

// Returns the covariance after heights are scaled by eta. The covariance scales by eta^2, and the mean slope by eta (LEADR 4.2, Height
// Scaling).
vec3 scale_height(const vec3 S, const float eta) {
    return S * (eta * eta);
}

// Adds the slopes of a base material of Beckmann roughness alpha (alpha^2 = 2 sigma^2; LEADR's Beckmann moments).
vec3 add_roughness(const vec3 S, const float alpha) {
    return S + vec3(vec2(0.5 * alpha * alpha), 0.0);
}

// Adds the variation of the macrosurface's own slope across the pixel. dx and dy are the differences of this slope between neighbouring
// pixels. The function is a Gaussian pixel filter of variance 0.25 in slope space (Tokuyoshi & Kaplanyan 2019). The authors bound alpha^2
// of an isotropic kernel to 0.18. Here the trace is bounded instead, which keeps creases and silhouettes glossy.
vec3 add_macro_curvature(const vec3 S, vec2 dx, vec2 dy) {
    dx = clamp(dx, -1e3, 1e3);
    dy = clamp(dy, -1e3, 1e3);
    vec3 kernel = 0.25 * vec3(dx * dx + dy * dy, dx.x * dx.y + dy.x * dy.y);
    return S + kernel * min(1.0, 0.18 / max(kernel.x + kernel.y, 1e-12));
}

#endif
