#ifndef LEADR_PHONG_GLSL
#define LEADR_PHONG_GLSL

#include "../constants.glsl"
#include "../slopes/grid.glsl"
#include "ggx_lobes.glsl"

// Facets with a Phong distribution of normals (LEADR section 6), about any mean slope and with any covariance C of the slopes.
// crates/leadr-reflectance/src/integrals/phong.rs has the derivation.

const int LEADR_PHONG_LOBES = 2;

// Returns the Cholesky factor of a covariance of at least the smallest variance.
vec3 phong_cholesky(const vec3 C) {
    return slope_cholesky(vec3(max(C.xy, LEADR_MIN_VARIANCE), C.z));
}

// Returns Phong's exponent of facets with this covariance.
float phong_exponent(const vec3 C) {
    vec3 c = phong_cholesky(C);
    return 1.0 / (c.x * c.z);
}

// Returns the density of the slopes.
float phong_p22(const vec2 slope, const vec2 m, const vec3 C) {
    vec3 c = phong_cholesky(C);
    vec2 d = slope - m;
    float n = 1.0 / (c.x * c.z), x = d.x / c.x, y = (d.y - c.y * x) / c.z;
    float square = (x * x + y * y) / n;
    // For large n, ln(1 + x) is needed to more digits than 1 + x has.
    float log_one_plus = square < 1e-2 ? square * (1.0 - square * (0.5 - square * (1.0 / 3.0 - 0.25 * square))) : log(1.0 + square);
    return (n + 2.0) * (0.5 / LEADR_PI) * exp(-0.5 * (n + 4.0) * log_one_plus);
}

// Returns the density D(wh) of the normals per macro area and solid angle. It is 0 for wh.z <= 0.
float phong_ndf(const vec3 wh, const vec2 m, const vec3 C) {
    if (wh.z <= 0.0) return 0.0;
    float z = max(wh.z, LEADR_MIN_NORMAL_Z);
    return phong_p22(-wh.xy / z, m, C) / (z * z * z * z);
}

// Returns the covariance of the Gaussian facets with which Walter et al. (2007) mask Phong facets.
vec3 phong_masking(const vec3 C) {
    float n = phong_exponent(C);
    return C * (n / (n + 2.0));
}

// Returns one of the Gaussian surfaces that approximate the facets: the wider for k = 0, the narrower for k = 1.
GaussianLobe phong_lobe(const vec3 C, const int k) {
    float t = inversesqrt(0.5 * phong_exponent(C) + 2.0);
    float by = k == 0 ? 1.0 + t : 1.0 - t;
    return GaussianLobe(0.5 * by, by * phong_masking(C));
}

// Returns the visible area of the surface along w. cholesky is the Cholesky factor of phong_masking.
DirectionArea phong_area(const vec3 w, const vec2 m, const vec3 C, const vec3 cholesky) {
    vec2 whitened = whitened_direction(w, cholesky);
    GaussianLobe wide = phong_lobe(C, 0), narrow = phong_lobe(C, 1);
    float visible = wide.weight * visible_area(w, m, wide.S) + narrow.weight * visible_area(w, m, narrow.S);
    return DirectionArea(whitened, length(whitened), meso_area(w, m), visible);
}

#endif
