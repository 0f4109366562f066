#ifndef LEADR_BECKMANN_GLSL
#define LEADR_BECKMANN_GLSL

#include "slope_statistics.glsl"

// P22(slope): bivariate Gaussian density of slopes (LEADR eq. 8). Variances are at least MIN_VARIANCE.
float beckmann_p22(vec2 slope, vec2 m, vec3 S) {
    S = clamp_covariance(vec3(max(S.xy, LEADR_MIN_VARIANCE), S.z));
    vec2 d = slope - m;
    // Conditional form: x, then y given x. Loses less than the adjugate when the correlation is strong.
    float k = S.z / S.x;
    float v = S.y - k * S.z;
    float e = d.y - k * d.x;
    return exp(-0.5 * (d.x * d.x / S.x + e * e / v)) / (2.0 * LEADR_PI * sqrt(S.x * v));
}

// D(wh) = P22(slope of wh) / wh.z^4, normals per macro area and solid angle (LEADR eq. 10); 0 for wh.z <= 0.
float beckmann_ndf(vec3 wh, vec2 m, vec3 S) {
    if (wh.z <= 0.0) return 0.0;
    float z = max(wh.z, LEADR_MIN_NORMAL_Z);
    float z2 = z * z;
    return beckmann_p22(-wh.xy / z, m, S) / (z2 * z2);
}

#endif
