#ifndef LEADR_BECKMANN_GLSL
#define LEADR_BECKMANN_GLSL

#include "projected_area.glsl"
#include "slope_distribution.glsl"
#include "slope_statistics.glsl"

// P22(slope): bivariate Gaussian density of slopes (LEADR eq. 8), over `divisor`: what follows it costs no division of its
// own. Variances are at least MIN_VARIANCE.
float beckmann_p22_over(vec2 slope, vec2 m, vec3 S, float divisor) {
    vec2 sigma = sqrt(clamp(S.xy, LEADR_MIN_VARIANCE, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE));
    float r = slope_correlation(sigma, S.z);
    // Whitened: x, then y given x. Loses less than the adjugate when the correlation is strong.
    vec2 u = (slope - m) / sigma;
    float q = sqrt((1.0 - r) * (1.0 + r));
    float v = (u.y - r * u.x) / q;
    return exp(-0.5 * (u.x * u.x + v * v)) / (2.0 * LEADR_PI * sigma.x * sigma.y * q * divisor);
}
float beckmann_p22(vec2 slope, vec2 m, vec3 S) {
    return beckmann_p22_over(slope, m, S, 1.0);
}

// D(wh) = P22(slope of wh) / wh.z^4, normals per macro area and solid angle (LEADR eq. 10), over `divisor`, which is at
// least MIN_AREA (the quotient stays below 1e32); 0 for wh.z <= 0.
float beckmann_ndf_over(vec3 wh, vec2 m, vec3 S, float divisor) {
    if (wh.z <= 0.0) return 0.0;
    float z = max(wh.z, LEADR_MIN_NORMAL_Z);
    float z2 = z * z;
    return beckmann_p22_over(-wh.xy / z, m, S, z2 * z2 * divisor);
}
float beckmann_ndf(vec3 wh, vec2 m, vec3 S) {
    return beckmann_ndf_over(wh, m, S, 1.0);
}

// Density of visible normals, max(0, wo.wn) D(wn) / A(wo), per solid angle; at most 1e37.
float beckmann_vndf(vec3 wo, vec3 wn, vec2 m, vec3 S) {
    return visible_density(wo, wn, beckmann_ndf(wn, m, S), visible_area(wo, m, S));
}

#endif
