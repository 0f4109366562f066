#ifndef LEADR_LIGHT_SIZE_GLSL
#define LEADR_LIGHT_SIZE_GLSL

// Highlights of a small light that is not a point. variance: of its directions, radians^2 along each of two axes across wi.
// Averaged over the light, the density of facets at the half vector is that of wider lobes (derived in
// crates/leadr-reflectance/src/integrals/light_size.rs).

// Least z of wo + wi in deviations of the light. Nearer the horizon, slopes are too nonlinear across the light.
const float LEADR_LEAST_HALF_Z = 16.0;

// Covariance of the facet slopes that reflect the light to wo; add it to that of the surface's slopes.
vec3 light_slope_covariance(const vec3 wo, const vec3 wi, const float variance) {
    vec3 h = wo + wi;
    float per = 1.0 / max(h.z, max(LEADR_LEAST_HALF_Z * sqrt(variance), 1e-3));
    vec2 s = -h.xy * per;
    vec2 q = wi.xy + s * wi.z;
    return (variance * per * per) * vec3(1.0 + s * s - q * q, s.x * s.y - q.x * q.y);
}

// Variance of half vectors, mean of both axes. cosine: between wo and the half vector.
float light_normal_variance(const float cosine, const float variance) {
    return 0.125 * variance * (1.0 + 1.0 / max(cosine * cosine, 1e-3));
}

#endif
