#ifndef LEADR_CLASS_ENVIRONMENT_GLSL
#define LEADR_CLASS_ENVIRONMENT_GLSL

#include "../masking/class_sky.glsl"
#include "../slopes/grid.glsl"
#include "slopes.glsl"

// Computes the environment that the visible facets of each class see, as one irradiance lookup per class
// (crates/leadr-reflectance/src/visible/class_environment.rs).

struct ClassEnvironment {
    vec3 normal; // direction of the irradiance lookup, unit length, in the tangent frame
    float open;  // factor on the irradiance of the lookup, 0..1
    float seen;  // fraction of the hemisphere, weighted by the cosine, in which the facets see the sky; in the rest they see other facets
};

// Returns the environment that a class of mean slope m and slope covariance S sees. depth is its optical depth towards the sky, open is its
// openness towards the viewer wo, and mean is the mean slope of all classes.
ClassEnvironment class_environment(const vec3 wo, const vec2 m, const vec3 S, const vec2 mean, const float open, const float depth) {
    float per_square = 1.0 / (1.0 + dot(mean, mean));
    VisibleSlopes v = visible_slopes(wo, m, S);
    float both = depth * open;
    float cosine = mean_inverse_normal_length(v.mean, v.cov) * (1.0 + dot(mean, v.mean)) * sqrt(per_square);
    float seen = clamp((0.5 + 0.5 * cosine) / (1.0 + both), 0.0, 1.0);
    vec2 off = v.mean - mean;
    float lean = 1.0 + 0.53 * sqrt(dot(off, off) * per_square) + 0.27 * sqrt((v.cov.x + v.cov.y) * per_square) + 2.0 * both;
    vec3 normal = normal_of_slope(mean + off / lean);
    return ClassEnvironment(normal, min(seen / (0.5 + 0.5 * dot(normal, normal_of_slope(mean))), 1.0), seen);
}

#endif
