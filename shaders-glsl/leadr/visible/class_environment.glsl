#ifndef LEADR_CLASS_ENVIRONMENT_GLSL
#define LEADR_CLASS_ENVIRONMENT_GLSL

#include "diffuse.glsl"

// Computes the environment that the visible facets of a class see, from twelve directions
// (crates/leadr-reflectance/src/visible/class_environment.rs). With wi = sky_direction(i) in the frame of the mesosurface, and the fraction
// lit of the facets that is lit from wi, a class reflects this part of the light that it would reflect without shadows:
//     sum of lit * mean_cosine(visible, wi) * radiance / sum of mean_cosine(visible, wi) * radiance

const int LEADR_SKY_DIRECTIONS = 12;

// Returns direction i in a frame whose z axis is the normal of the mesosurface. Each direction stands for a twelfth of the hemisphere. The
// directions lie on two rings, at the heights of Gauss's rule.
vec3 sky_direction(const int i) {
    const vec3 directions[LEADR_SKY_DIRECTIONS] = vec3[](
        vec3(0.9441112, 0.2529738, 0.2113249),
        vec3(0.2529738, 0.9441112, 0.2113249),
        vec3(-0.6911374, 0.6911374, 0.2113249),
        vec3(-0.9441112, -0.2529738, 0.2113249),
        vec3(-0.2529738, -0.9441112, 0.2113249),
        vec3(0.6911374, -0.6911374, 0.2113249),
        vec3(0.4347365, 0.4347365, 0.7886751),
        vec3(-0.1591246, 0.5938611, 0.7886751),
        vec3(-0.5938611, 0.1591246, 0.7886751),
        vec3(-0.4347365, -0.4347365, 0.7886751),
        vec3(0.1591246, -0.5938611, 0.7886751),
        vec3(0.5938611, -0.1591246, 0.7886751)
    );
    return directions[i];
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
