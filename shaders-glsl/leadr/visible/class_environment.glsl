#ifndef LEADR_CLASS_ENVIRONMENT_GLSL
#define LEADR_CLASS_ENVIRONMENT_GLSL

#include "../frame.glsl"
#include "diffuse.glsl"

// Computes the environment that the visible facets of a class see, from a few directions
// (crates/leadr-reflectance/src/visible/class_environment.rs). With wi = sky_direction(i) in sky_frame(up, wo), and the fraction lit of the
// facets that is lit from wi, a class reflects this part of the light that it would reflect without shadows:
//     sum of lit * mean_cosine(visible, wi) * radiance / (sum of mean_cosine(visible, wi) * radiance + ground)
// Here, ground is the light from below in the same sums, most of it from wi = ground_direction(i). The mesosurface blocks it.

const int LEADR_SKY_DIRECTIONS = 15;
const int LEADR_GROUND_DIRECTIONS = 6;
// Returns the frame of the directions. up is the normal of the mesosurface.
Frame sky_frame(const vec3 up, const vec3 wo) {
    vec3 x = wo - dot(wo, up) * up;
    float square = dot(x, x);
    if (square < 1e-8) return frame_about(up);
    x *= inversesqrt(square);
    return Frame(x, cross(up, x), up);
}

// Returns direction i of the sky. The directions lie on three rings, at the heights of Gauss's rule. The first direction has the azimuth of
// the viewer.
vec3 sky_direction(const int i) {
    const vec3 directions[LEADR_SKY_DIRECTIONS] = vec3[](
        vec3(0.9936289, 0.0000000, 0.1127017),
        vec3(0.4968144, 0.8605078, 0.1127017),
        vec3(-0.4968144, 0.8605078, 0.1127017),
        vec3(-0.9936289, 0.0000000, 0.1127017),
        vec3(-0.4968144, -0.8605078, 0.1127017),
        vec3(0.4968144, -0.8605078, 0.1127017),
        vec3(0.7500000, 0.4330127, 0.5000000),
        vec3(0.0000000, 0.8660254, 0.5000000),
        vec3(-0.7500000, 0.4330127, 0.5000000),
        vec3(-0.7500000, -0.4330127, 0.5000000),
        vec3(0.0000000, -0.8660254, 0.5000000),
        vec3(0.7500000, -0.4330127, 0.5000000),
        vec3(0.4611959, 0.0000000, 0.8872983),
        vec3(-0.2305980, 0.3994074, 0.8872983),
        vec3(-0.2305980, -0.3994074, 0.8872983)
    );
    return directions[i];
}

// Returns the weight of direction i of the sky. The mean weight is 1.
float sky_weight(const int i) {
    return i < 6 ? 0.6944444 : (i < 12 ? 1.1111111 : 1.3888889);
}

// Returns direction i from below the mesosurface, on two rings.
vec3 ground_direction(const int i) {
    const vec3 directions[LEADR_GROUND_DIRECTIONS] = vec3[](
        vec3(0.4974937, 0.8616844, -0.1000000),
        vec3(-0.9949874, 0.0000000, -0.1000000),
        vec3(0.4974937, -0.8616844, -0.1000000),
        vec3(0.4582576, 0.7937254, -0.4000000),
        vec3(-0.9165151, 0.0000000, -0.4000000),
        vec3(0.4582576, -0.7937254, -0.4000000)
    );
    return directions[i];
}

// Returns the weight of direction i from below, for the weights of sky_weight.
float ground_weight(const int i) {
    return i < 3 ? 1.2500000 : 2.0000000;
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
