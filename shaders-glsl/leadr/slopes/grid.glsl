#ifndef LEADR_SLOPE_GRID_GLSL
#define LEADR_SLOPE_GRID_GLSL

#include "statistics.glsl"

// The N x N grid of slopes over P22 (LEADR 5.1). A grid of N = 1 consists of the mean slope alone.

// Returns the half extent of the grid in standard deviations. The half extent is 0 for N = 1, then 0.3 (N + 1) up to 3 (1.8 for N = 5, as
// in the paper). From N = 32 on, every doubling of N adds 0.8, so that the sum converges to the integral.
float grid_lambda(const int n) {
    return n <= 1 ? 0.0 : min(0.3 * float(n + 1), 3.0) + 0.8 * log2(max(float(n) / 32.0, 1.0));
}

// Returns the distance between neighbouring nodes, in standard deviations. For N = 1 it is sqrt(12), the width of a box of the
// same variance.
float grid_spacing(const int n, const float lambda) {
    return n <= 1 ? 3.4641016 : 2.0 * lambda / float(n - 1);
}

// Returns (p_j, p_k, weight) of node j, k in 0..N-1. The weights are not normalised, because the estimators divide by the sum of the
// weights.
vec3 grid_node(const int j, const int k, const int n, const float lambda) {
    if (n <= 1) return vec3(0.0, 0.0, 1.0);
    vec2 p = lambda * (2.0 * vec2(j, k) / float(n - 1) - 1.0);
    return vec3(p, exp(-0.5 * dot(p, p)));
}

// Returns the lower Cholesky factor (c_xx, c_yx, c_yy) of the covariance. Compute it once per pixel.
vec3 slope_cholesky(const vec3 S) {
    vec2 sigma = sqrt(clamp(S.xy, 0.0, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE));
    float r = slope_correlation(sigma, S.z);
    return vec3(sigma.x, sigma.y * r, sigma.y * sqrt((1.0 - r) * (1.0 + r)));
}

// Returns the slope at standard normal coordinates p (LEADR 5.1).
vec2 slope_at(const vec2 p, const vec2 m, const vec3 cholesky) {
    return m + vec2(cholesky.x * p.x, cholesky.y * p.x + cholesky.z * p.y);
}

// Like slope_at, but computes the slope from the covariance S instead of its Cholesky factor.
vec2 slope_sample(const vec2 p, const vec2 m, const vec3 S) {
    return slope_at(p, m, slope_cholesky(S));
}

// Returns the unit normal of a slope (LEADR eq. 11).
vec3 normal_of_slope(const vec2 slope) {
    return vec3(-slope, 1.0) * inversesqrt(dot(slope, slope) + 1.0);
}

// Returns <wn, wo> / (wn . wg), the projected area of the facet of this slope per unit of macrosurface, or 0 when the facet
// faces away.
float facet_area(const vec3 wo, const vec2 slope) {
    return max(wo.z - dot(wo.xy, slope), 0.0);
}

#endif
