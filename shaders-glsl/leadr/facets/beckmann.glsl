#ifndef LEADR_BECKMANN_GLSL
#define LEADR_BECKMANN_GLSL

#include "projected_area.glsl"
#include "slope_distribution.glsl"
#include "../slopes/statistics.glsl"

// Returns the bivariate Gaussian density of covariance S at the slope offset e / z, divided by `divisor`. z2 is z^2, from 1e-8 to 1.
// Dividing by z2 and the divisor in one step saves divisions. Variances must be at least MIN_VARIANCE.
float gaussian_over(const vec2 e, const float z2, const vec3 S, const float divisor) {
    vec2 v = clamp(S.xy, LEADR_MIN_VARIANCE, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE);
    float p = sqrt(v.x * v.y);
    float r = clamp(S.z / p, -LEADR_MAX_CORRELATION, LEADR_MAX_CORRELATION);
    float q = (1.0 - r) * (1.0 + r);
    float det = v.x * v.y * q;
    // The code whitens the slope x first, and then y given x. Whitening in this order is more accurate than the adjugate at strong
    // correlation.
    float y = v.x * e.y - p * r * e.x;
    float square = (e.x * e.x * det + y * y) / (v.x * det * z2);
    return exp(-0.5 * square) / (2.0 * LEADR_PI * p * sqrt(q) * divisor);
}

// Returns P22(slope), the bivariate Gaussian density of slopes (LEADR eq. 8).
float beckmann_p22(const vec2 slope, const vec2 m, const vec3 S) {
    return gaussian_over(slope - m, 1.0, S, 1.0);
}

// Returns D(wh) = P22(slope of wh) / wh.z^4, the density of normals per macro area and solid angle (LEADR eq. 10), divided by
// `divisor`. The divisor must be at least MIN_AREA, so that the quotient stays below 1e32. The result is 0 for wh.z <= 0.
float beckmann_ndf_over(const vec3 wh, const vec2 m, const vec3 S, const float divisor) {
    if (wh.z <= 0.0) return 0.0;
    float z = max(wh.z, LEADR_MIN_NORMAL_Z);
    float z2 = z * z;
    return gaussian_over(wh.xy + z * m, z2, S, z2 * z2 * divisor);
}
float beckmann_ndf(const vec3 wh, const vec2 m, const vec3 S) {
    return beckmann_ndf_over(wh, m, S, 1.0);
}

// Returns the density of visible normals, max(0, wo.wn) D(wn) / A(wo), per solid angle, at most 1e37.
float beckmann_vndf(const vec3 wo, const vec3 wn, const vec2 m, const vec3 S) {
    return visible_density(wo, wn, beckmann_ndf(wn, m, S), visible_area(wo, m, S));
}

#endif
