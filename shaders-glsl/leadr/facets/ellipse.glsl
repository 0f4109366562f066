#ifndef LEADR_ELLIPSE_GLSL
#define LEADR_ELLIPSE_GLSL

#include "../constants.glsl"

// Parameterisations of anisotropic roughness (thesis eq. 2.25-2.34). The roughness matrix is A = (a_xx, a_yy, a_xy). A Beckmann
// surface has the slope covariance A / 2.

// An ellipse of roughness: its radii (conversions return alpha_1 >= alpha_2), and the counter-clockwise angle from the x slope to the first
// axis.
struct Ellipse {
    vec2 radii;
    float angle;
};

// The scales (alpha_x, alpha_y), the correlation rho, and sqrt(1 - rho^2). For a thin ellipse, the root is too inaccurate if it is computed
// from rho.
struct Bivariate {
    vec2 alpha;
    float rho;
    float independence;
};

Bivariate bivariate_from_ellipse(const Ellipse e) {
    float s = sin(e.angle);
    float c = cos(e.angle);
    vec2 alpha = vec2(length(e.radii * vec2(c, s)), length(e.radii * vec2(s, c)));
    float product = alpha.x * alpha.y;
    if (product < 1e-30) return Bivariate(alpha, 0.0, 1.0);
    float difference = (e.radii.x - e.radii.y) * (e.radii.x + e.radii.y);
    return Bivariate(alpha, clamp(difference * s * c / product, -1.0, 1.0), min(e.radii.x * e.radii.y / product, 1.0));
}

Ellipse ellipse_from_bivariate(const Bivariate b) {
    float product = b.alpha.x * b.alpha.y;
    float difference = (b.alpha.x - b.alpha.y) * (b.alpha.x + b.alpha.y);
    float twice = 2.0 * b.rho * product;
    float major = sqrt(0.5 * (dot(b.alpha, b.alpha) + length(vec2(difference, twice))));
    float angle = twice == 0.0 ? (difference < 0.0 ? LEADR_PI : 0.0) : atan(twice, difference);
    return Ellipse(vec2(major, min(product * b.independence / max(major, 1e-15), major)), 0.5 * angle);
}

vec3 roughness_from_ellipse(const Ellipse e) {
    float s = sin(e.angle);
    float c = cos(e.angle);
    vec2 r = e.radii * e.radii;
    return vec3(r.x * c * c + r.y * s * s, r.x * s * s + r.y * c * c,
                (e.radii.x - e.radii.y) * (e.radii.x + e.radii.y) * s * c);
}

vec3 roughness_from_bivariate(const Bivariate b) {
    return vec3(b.alpha * b.alpha, b.rho * b.alpha.x * b.alpha.y);
}

// Converts a roughness matrix. A matrix made indefinite by rounding is treated as fully correlated. If the minor radius is below 4e-4 of
// the major radius, rounding determines its value.
Bivariate bivariate_from_roughness(const vec3 A) {
    vec2 alpha = sqrt(max(A.xy, 0.0));
    float product = alpha.x * alpha.y;
    if (product < 1e-30) return Bivariate(alpha, 0.0, 1.0);
    float rho = clamp(A.z / product, -1.0, 1.0);
    return Bivariate(alpha, rho, sqrt((1.0 - rho) * (1.0 + rho)));
}

Ellipse ellipse_from_roughness(const vec3 A) {
    return ellipse_from_bivariate(bivariate_from_roughness(A));
}

#endif
