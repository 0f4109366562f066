#ifndef LEADR_BECKMANN_SAMPLING_GLSL
#define LEADR_BECKMANN_SAMPLING_GLSL

#include "normal_distribution.glsl"
#include "projected_area.glsl"
#include "../slopes/grid.glsl"

// Samples visible Beckmann normals exactly by inversion, for every mean slope and every viewer.
// crates/leadr-reflectance/src/facets/beckmann_sampling.rs has the derivation.

// Returns the upper-tail quantile of a gamma distribution at the normal deviate z , by the cube of Wilson and Hilferty.
float gamma_quantile(const float z, const float mean, const float variance) {
    float shape = max(mean * mean / max(variance, 1e-30), 2.0);
    float cube = max(1.0 - 1.0 / (9.0 * shape) - z / (3.0 * sqrt(shape)), 0.02);
    return mean * cube * cube * cube;
}

// Returns F and its derivative F', both divided by phi(min(nu, 0)), at x = min(nu, 0) + w. The function is F(x) = nu Phi(x) + phi(x). p and
// n are the positive and the negative part of nu.
vec2 visible_part(const float w, const float p, const float n) {
    float x = n + w;
    float y = p - w;
    float e = exp(-w * (n + 0.5 * w));
    float tail = mills_ratio(abs(x));
    float part = x <= 0.0 ? e * (tail_mean_ratio(-x) + y * tail) : p * (2.5066283 - e * tail) + e;
    return vec2(part, y * e);
}

// Returns the slope x <= nu of the unit surface that solves (nu Phi(x) + phi(x)) / (nu Phi(nu) + phi(nu)) = u. The slope x is a quantile of
// the visible slopes along the viewer's azimuth. nu is the projected area of the mesosurface in units of the spread.
float visible_slope_quantile(float u, const float nu) {
    u = clamp(u, 2.9802322e-8, 0.99999994);
    float p = clamp(nu, 0.0, 1e15);
    float n = clamp(nu, -1e15, 0.0);
    float z = normal_quantile(u);
    float total;
    float w;
    if (nu > 0.0) {
        float t = min(p, 13.0);
        float e = exp(-0.5 * t * t);
        total = 2.5066283 * p + e * tail_mean_ratio(t);
        float pull = (2.5066283 - e * mills_ratio(t)) / total;
        float variance = max(2.0 - (p + pull) * pull, 1e-3);
        w = nu > 5.0 ? sqrt(variance) * z - pull : p - gamma_quantile(z, p + pull, variance);
    } else {
        float t = -n;
        total = tail_mean_ratio(t);
        float mean = t > 8.0 ? 2.0 / (t + 3.0 / t) : mills_ratio(t) / total - t;
        w = -max(gamma_quantile(z, mean, 2.0 - mean * (mean + t)), sqrt(2.0 * (1.0 - u) * total));
    }
    float low = -9.0;
    float high = min(p, 7.0);
    w = clamp(w, low, high);
    for (int i = 0; i < 5; ++i) {
        vec2 f = visible_part(w, p, n);
        float rest = max(total - f.x, 0.0);
        float change = u < 0.5 ? -f.x * log(max(f.x, 1e-37) / (u * total))
                               : 2.0 * (rest - sqrt(rest) * sqrt((1.0 - u) * total));
        // The sign of the step decides which end of the bracket moves, because near the root the sign of f.x can be a rounding error.
        if (change > 0.0) low = w; else high = w;
        float next = w + change / max(f.y, 1e-37);
        // The code bisects the bracket if the next value is outside or not a number.
        w = next >= low && next <= high ? next : 0.5 * (low + high);
    }
    return n + w;
}

// Returns a visible normal for u in [0, 1)^2, distributed as beckmann_vndf(wo, wn, m, S). u.x selects the slope along the viewer's azimuth,
// and u.y selects the slope across this azimuth.
vec3 beckmann_sample_visible(const vec3 wo, const vec2 u, const vec2 m, const vec3 S) {
    vec3 c = slope_cholesky(vec3(max(S.xy, LEADR_MIN_VARIANCE), S.z));
    vec2 t = vec2(c.x * wo.x + c.y * wo.y, c.z * wo.y);
    float b = length(t);
    vec2 e = b > 1e-18 ? t / b : vec2(1.0, 0.0);
    float x = visible_slope_quantile(u.x, clamp(meso_area(wo, m) / max(b, 1e-18), -1e15, 1e15));
    float across = normal_quantile(u.y);
    return normal_of_slope(slope_at(vec2(e.x * x - e.y * across, e.y * x + e.x * across), m, c));
}

#endif
