#ifndef LEADR_LIGHT_SIZE_GLSL
#define LEADR_LIGHT_SIZE_GLSL

// Computes highlights of a small light that is not a point. variance is the variance of the light's directions, in radians^2 along each of
// two axes across wi. Averaging over the light widens the lobes of the density of half vectors.
// crates/leadr-reflectance/src/integrals/light_size.rs has the derivation.

// The smallest z of wo + wi, in standard deviations of the light. Closer to the horizon, the slopes vary too nonlinearly across the light.
const float LEADR_LEAST_HALF_Z = 16.0;

// Returns the covariance of the facet slopes that reflect the light to wo. Add it to the covariance of the surface's slopes.
vec3 light_slope_covariance(const vec3 wo, const vec3 wi, const float variance) {
    vec3 h = wo + wi;
    float per = 1.0 / max(h.z, max(LEADR_LEAST_HALF_Z * sqrt(variance), 1e-3));
    vec2 s = -h.xy * per;
    vec2 q = wi.xy + s * wi.z;
    return (variance * per * per) * vec3(1.0 + s * s - q * q, s.x * s.y - q.x * q.y);
}

// Returns the variance of the half vectors, averaged over both axes. cosine is the cosine between wo and the half vector.
float light_normal_variance(const float cosine, const float variance) {
    return 0.125 * variance * (1.0 + 1.0 / max(cosine * cosine, 1e-3));
}

#endif
