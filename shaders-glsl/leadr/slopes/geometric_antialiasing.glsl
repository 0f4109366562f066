#ifndef LEADR_GEOMETRIC_ANTIALIASING_GLSL
#define LEADR_GEOMETRIC_ANTIALIASING_GLSL

#include "../fma.glsl"
#include "packing.glsl"

// Converts the variation of the normal across a pixel to roughness in slope space (Tokuyoshi & Kaplanyan 2019 and its supplement). Filter
// kernels are given as covariances (s_xx, s_yy, s_xy). crates/leadr-reflectance/src/slopes/geometric_antialiasing.rs explains how the forms
// are related. add_macro_curvature adds the kernel of the normal alone.

const float LEADR_PIXEL_VARIANCE = 0.25; // variance of the pixel filter, in squared pixels
const float LEADR_KERNEL_COVER = 3.0;    // ratio of kernel to slope covariance at which half of the kernel's excess is added
const float LEADR_KERNEL_BOUND = 0.18;   // bound on the trace of the kernel on the sphere, in squared radians

// Returns the kernel at the half vector wh (tangent frame). dx and dy are the differences of wh between neighbouring pixels.
vec3 half_vector_kernel(const vec3 wh, vec3 dx, vec3 dy) {
    dx = clamp(dx, -1e3, 1e3);
    dy = clamp(dy, -1e3, 1e3);
    dx -= wh * dot(wh, dx);
    dy -= wh * dot(wh, dy);
    float angle = LEADR_PIXEL_VARIANCE * (dot(dx, dx) + dot(dy, dy));
    float scale = LEADR_PIXEL_VARIANCE * min(1.0, LEADR_KERNEL_BOUND / max(angle, 1e-12));
    float z = max(wh.z, LEADR_MIN_NORMAL_Z);
    vec2 slope = -wh.xy / z;
    vec2 u = (slope * dx.z + dx.xy) / z;
    vec2 v = (slope * dy.z + dy.xy) / z;
    return clamp_covariance(scale * vec3(u * u + v * v, u.x * u.y + v.x * v.y));
}

// Moves the kernel from the normal to `slope`, as (I + p p^T) K (I + p p^T). The second-order term is limited to one half.
vec3 tilt_kernel(vec3 kernel, const vec2 slope) {
    vec3 p = vec3(slope * slope, slope.x * slope.y);
    kernel *= min(1.0, 0.25 / max(dot(p.xy, kernel.xy) + 2.0 * p.z * kernel.z, 1e-12));
    vec2 u = vec2(1.0 + p.x, p.z);
    vec2 v = vec2(p.z, 1.0 + p.y);
    vec2 ku = vec2(kernel.x * u.x + kernel.z * u.y, kernel.z * u.x + kernel.y * u.y);
    vec2 kv = vec2(kernel.x * v.x + kernel.z * v.y, kernel.z * v.x + kernel.y * v.y);
    return clamp_covariance(vec3(dot(u, ku), dot(v, kv), dot(u, kv)));
}

// Returns the covariance that the kernel adds to slopes of covariance S. Surfaces with smooth slopes get the kernel's full variance of 0.25
// squared pixels. On rough surfaces the difference is not visible, so they get little more than 1/12, the variance of a pixel.
vec3 kernel_over(const vec3 kernel, const vec3 S) {
    vec3 T = LEADR_KERNEL_COVER * S;
    vec3 whole = kernel + T;
    float of_kernel = max(fma(kernel.x, kernel.y, -kernel.z * kernel.z), 0.0);
    float of_slopes = max(fma(T.x, T.y, -T.z * T.z), 0.0);
    float per = 1.0 / max(fma(whole.x, whole.y, -whole.z * whole.z), max(of_kernel + of_slopes, 1e-30));
    return kernel - (2.0 / 3.0 * per) * (of_slopes * kernel + of_kernel * T);
}

// The following kernels are cheaper, and at least as wide as the full kernel in every direction.
vec3 axis_aligned_kernel(const vec3 kernel) {
    return vec3(kernel.xy + abs(kernel.z), 0.0);
}
vec3 isotropic_kernel(const vec3 kernel) {
    return vec3(vec2(principal_variances(kernel).x), 0.0);
}

// Returns the matrix with its off-diagonal element reduced until the determinant is at least tau.
vec3 clamp_determinant(const vec3 A, const float tau) {
    float c = sqrt(max(fma(A.x, A.y, -tau), 0.0));
    return vec3(A.xy, clamp(A.z, -c, c));
}

// Adds the kernel to the covariance of a Gaussian surface, or to the roughness matrix of GGX (alpha^2 = 2 sigma^2).
vec3 filter_covariance(const vec3 S, const vec3 kernel) {
    return clamp_determinant(S + kernel, max(fma(S.x, S.y, -S.z * S.z), 0.0));
}
vec3 filter_roughness(const vec3 A, const vec3 kernel) {
    return clamp_determinant(A + 2.0 * kernel, max(fma(A.x, A.y, -A.z * A.z), 0.0));
}

// Returns D(wh) of GGX with mean slope m and roughness matrix A, whose determinant is raised to tau (supplement, 1). The result is 0 for
// wh.z <= 0.
float ggx_ndf_clamped(const vec3 wh, const vec2 m, const vec3 A, const float tau) {
    if (wh.z <= 0.0) return 0.0;
    float det = max(fma(A.x, A.y, -A.z * A.z), max(tau, 1e-16));
    vec2 d = wh.xy + wh.z * m;
    float q = max(A.y * d.x * d.x + A.x * d.y * d.y - 2.0 * A.z * d.x * d.y, 0.0) / det;
    float g = 1.0 / max(q + wh.z * wh.z, 1e-13);
    return g * g / (LEADR_PI * sqrt(det));
}

#endif
