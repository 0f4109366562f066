#ifndef LEADR_CLASS_ENVIRONMENT_GLSL
#define LEADR_CLASS_ENVIRONMENT_GLSL

#include "../frame.glsl"
#include "diffuse.glsl"

// Computes the environment that the visible facets of a class see, from a few directions
// (crates/leadr-reflectance/src/visible/class_environment.rs). With wi = sky_direction(i) in sky_frame(up, wo), and the fraction lit of the
// facets that is lit from wi, a class reflects this part of the light that it would reflect without shadows:
//     sum of lit * mean_cosine(visible, wi) * radiance / (sum of mean_cosine(visible, wi) * radiance + ground)
// Here, ground is the light from below in the same sums, most of it from wi = ground_direction(i). The mesosurface blocks it.

const int LEADR_SKY_DIRECTIONS = 14;
const int LEADR_GROUND_DIRECTIONS = 3;
// The decorrelation of viewer and light, averaged over the sixth of a ring about the viewer's azimuth.
const float LEADR_LEAST_SKY_DECORRELATION = 0.31;

// Returns the frame of the directions. up is the normal of the mesosurface.
Frame sky_frame(const vec3 up, const vec3 wo) {
    vec3 x = wo - dot(wo, up) * up;
    float square = dot(x, x);
    if (square < 1e-8) return frame_about(up);
    x *= inversesqrt(square);
    return Frame(x, cross(up, x), up);
}

// Returns direction i of the sky. Each direction stands for an equal part of the hemisphere. The directions lie on three rings, at the
// heights of Gauss's rule. The first direction of the middle ring has the azimuth of the viewer.
vec3 sky_direction(const int i) {
    const vec3 directions[LEADR_SKY_DIRECTIONS] = vec3[](
        vec3(0.7026017, 0.7026017, 0.1127017),
        vec3(-0.7026017, 0.7026017, 0.1127017),
        vec3(-0.7026017, -0.7026017, 0.1127017),
        vec3(0.7026017, -0.7026017, 0.1127017),
        vec3(0.8660254, 0.0000000, 0.5000000),
        vec3(0.4330127, 0.7500000, 0.5000000),
        vec3(-0.4330127, 0.7500000, 0.5000000),
        vec3(-0.8660254, 0.0000000, 0.5000000),
        vec3(-0.4330127, -0.7500000, 0.5000000),
        vec3(0.4330127, -0.7500000, 0.5000000),
        vec3(0.3261148, 0.3261148, 0.8872983),
        vec3(-0.3261148, 0.3261148, 0.8872983),
        vec3(-0.3261148, -0.3261148, 0.8872983),
        vec3(0.3261148, -0.3261148, 0.8872983)
    );
    return directions[i];
}

// Returns direction i from below the mesosurface, near the mesosurface.
vec3 ground_direction(const int i) {
    float x = i == 0 ? 0.9607689 : -0.4803845;
    return vec3(x, i == 0 ? 0.0 : (i == 1 ? 0.8320503 : -0.8320503), -0.2773501);
}

// Returns E[max(0, x)] of a normal variable with this mean and variance, without an exponential. The error is less than 0.006 standard
// deviations.
float near_clamped_mean(const float mean, const float variance) {
    float per = inversesqrt(max(variance, 1e-12));
    float off = max(1.0 - abs(mean) * per * (1.0 / 3.1), 0.0);
    float square = off * off;
    return max(mean, 0.0) + 0.39894228 * (variance * per) * (square * square);
}

// Returns the mean of the clamped cosine towards wi over facets with these moments of the normals.
float mean_cosine(const NormalMoments normals, const vec3 wi) {
    float mean = dot(wi, normals.mean);
    float square = dot(wi * wi, normals.diag) + 2.0 * dot(wi.yzx * wi.zxy, normals.off);
    return near_clamped_mean(mean, max(square - mean * mean, 0.0));
}

#endif
