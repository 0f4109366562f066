#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "correlated_masking.glsl"
#include "visible_specular.glsl"

// Specular environments with the shadows that the surface throws on itself, for rules with few probes: the slopes that are
// visible and lit, by their moments. The line of probes is laid through these instead of through all that is visible.
// src/reflectance/shadowed_specular.rs derives it. Once per pixel
//     LitSlopes lit = lit_slopes(visibility, wo, visible_slopes(wo, m, S), line_rule(5));
//     VisibleLine line = line_of_slopes(lit.slopes, wo, size, LINE);
// then the probes as without shadows, and
//     reflected *= lit.lit;

struct LitSlopes {
    float lit;            // the part of what is visible, 0..1: what a constant environment keeps
    VisibleSlopes slopes; // their moments in place of those of all visible slopes
};

// The interval of y where a2 y^2 + b2 y + c2 > 0, a2 <= 0, within +-8; empty (x >= y) if nowhere.
vec2 positive_interval(float a2, float b2, float c2) {
    float discriminant = b2 * b2 - 4.0 * a2 * c2;
    if (discriminant <= 0.0) return c2 > 0.0 ? vec2(-8.0, 8.0) : vec2(8.0);
    float side = b2 < 0.0 ? -1.0 : 1.0;
    float k = b2 + side * sqrt(discriminant);
    float near = clamp(-2.0 * c2 / k, -8.0, 8.0);
    float far = -a2 * 16.0 > abs(k) ? -0.5 * k / a2 : 8.0 * side;
    return vec2(min(near, far), max(near, far));
}

// Where next to nothing is lit, its moments tend to those of what is visible, as if so much of that were lit besides.
const float LEADR_FAINT = 1e-3;

// v: the visible slopes; rule: nodes along the view's azimuth, of two evaluations each.
LitSlopes lit_slopes(int visibility, vec3 wo, VisibleSlopes v, LineRule rule) {
    if (visibility == LEADR_VISIBILITY_MASKING) return LitSlopes(1.0, v);
    vec3 cholesky = slope_cholesky(v.S);
    DirectionArea o = direction_area(wo, v.m, cholesky);
    // The whitened frame whose first axis is the view's azimuth.
    vec2 p = o.spread > 1e-9 ? o.whitened / o.spread : vec2(1.0, 0.0);
    float deviation = sqrt(v.variance);
    float skew = v.third / (6.0 * v.variance * deviation);
    vec2 along = deviation * vec2(cholesky.x * p.x, cholesky.y * p.x + cholesky.z * p.y);
    vec2 across = vec2(-cholesky.x * p.y, cholesky.z * p.x - cholesky.y * p.y);
    float ao = max(o.meso, 0.0);
    float lit = 0.0;
    vec2 mean = vec2(0.0);
    vec3 second = vec3(LEADR_FAINT, LEADR_FAINT, 0.0);
    for (int i = 0; i < rule.n; ++i) {
        float j = float(i) - 0.5 * float(rule.n - 1);
        float z = j * rule.step;
        float weight = rule.norm * exp(-rule.decay * j * j);
        float u = z + skew * (z * z - 1.0);
        vec2 slope = v.mean + along * u;
        float facet = max(v.facet - v.b * deviation * u, 0.0);
        // Reflections above the mesosurface.
        vec2 interval = positive_interval(-ao * dot(across, across), 2.0 * (facet * dot(across, v.m) - ao * dot(slope, across)),
                                          2.0 * facet * (1.0 + dot(slope, v.m)) - ao * (1.0 + dot(slope, slope)));
        if (interval.x >= interval.y) continue;
        // Mass, mean and standard deviation of the normal density over it, from the side where the tail is small.
        float side = interval.x + interval.y > 0.0 ? -1.0 : 1.0;
        if (side < 0.0) interval = -interval.yx;
        float pl = normal_pdf(interval.x);
        float ph = normal_pdf(interval.y);
        float mass = max(normal_cdf(interval.y) - normal_cdf(interval.x), 1e-6);
        float middle = clamp((pl - ph) / mass, interval.x, interval.y);
        float variance = clamp(1.0 + (interval.x * pl - interval.y * ph) / mass - middle * middle, 0.0, 1.0);
        float spread = min(sqrt(variance), 0.288675 * (interval.y - interval.x));
        for (int point = -1; point <= 1; point += 2) {
            float y = side * (middle + float(point) * spread);
            vec3 wn = normal_of_slope(slope + y * across);
            vec3 wi = 2.0 * dot(wn, wo) * wn - wo;
            float w = 0.5 * weight * mass * lit_fraction(visibility, o, direction_area(wi, v.m, cholesky));
            lit += w;
            mean += w * vec2(u, y);
            second += w * vec3(u * u, y * y, u * y);
        }
    }
    // Moments in u and y, then in slopes.
    float per = 1.0 / (lit + LEADR_FAINT);
    mean *= per;
    vec3 cov = second * per - vec3(mean * mean, mean.x * mean.y);
    cov.xy = max(cov.xy, 0.02);
    VisibleSlopes s = v;
    s.mean += along * mean.x + across * mean.y;
    s.cov = cov.x * vec3(along * along, along.x * along.y) + cov.y * vec3(across * across, across.x * across.y)
          + cov.z * vec3(2.0 * along * across, along.x * across.y + along.y * across.x);
    s.facet = max(v.facet - v.b * deviation * mean.x, 1e-6);
    s.variance = clamp(cov.x * v.variance, 0.02, 1.0);
    s.third = v.third * lit;
    return LitSlopes(lit, s);
}

#endif
