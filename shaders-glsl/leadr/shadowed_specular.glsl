#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "correlated_masking.glsl"
#include "visible_specular.glsl"

// Specular environments with the shadows that the surface throws on itself, for a line of few probes: what is lit is
// integrated over all visible slopes, then handed to the probes as a parabola along their line.
// src/reflectance/shadowed_specular.rs derives it. Once per pixel
//     VisibleSlopes v = visible_slopes(wo, m, S);
//     vec3 cholesky = slope_cholesky(v.S);
//     LitLine lit = lit_line(visibility, direction_area(wo, v.m, cholesky), wo, v, line.major, cholesky, line_rule(5));
// for each probe, with z = (i - (n-1)/2) step its place on the line,
//     float l = lit_along(lit, z);   reflected += l * f * L;   sum += l * p.weight;
// and at the end
//     reflected *= lit_scale(lit, sum);

// What is lit, by the standard normal coordinate z along the line: mean + slope z + curve (z^2 - 1).
struct LitLine {
    float mean; // what a constant environment keeps
    float slope;
    float curve;
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

// v: the visible slopes; o: of the viewer, for v.m and the cholesky of v.S; major: direction of the probes' line, of any
// length; rule: nodes along the view's azimuth, two evaluations each.
LitLine lit_line(int visibility, DirectionArea o, vec3 wo, VisibleSlopes v, vec2 major, vec3 cholesky, LineRule rule) {
    if (visibility == LEADR_VISIBILITY_MASKING) return LitLine(1.0, 0.0, 0.0);
    // The whitened frame whose first axis is the view's azimuth.
    vec2 p = o.spread > 1e-9 ? o.whitened / o.spread : vec2(1.0, 0.0);
    vec2 axis = vec2(cholesky.x * p.x, cholesky.y * p.x + cholesky.z * p.y);
    vec2 across = vec2(-cholesky.x * p.y, cholesky.z * p.x - cholesky.y * p.y);
    float deviation = sqrt(v.variance);
    float skew = v.third / (6.0 * v.variance * deviation);
    // The line in coordinates of unit variance along both.
    float x = major.x / max(cholesky.x, 1e-9);
    vec2 q = vec2(x, (major.y - cholesky.y * x) / max(cholesky.z, 1e-9));
    vec2 line = vec2(dot(p, q) / deviation, p.x * q.y - p.y * q.x);
    line = dot(line, line) > 1e-30 ? normalize(line) : vec2(1.0, 0.0);
    float ao = max(o.meso, 0.0);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < rule.n; ++i) {
        float j = float(i) - 0.5 * float(rule.n - 1);
        float z = j * rule.step;
        float weight = rule.norm * exp(-rule.decay * j * j);
        float u = z + skew * (z * z - 1.0);
        vec2 slope = v.mean + axis * (deviation * u);
        float facet = max(wo.z - dot(wo.xy, slope), 0.0);
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
        float mean = clamp((pl - ph) / mass, interval.x, interval.y);
        float variance = clamp(1.0 + (interval.x * pl - interval.y * ph) / mass - mean * mean, 0.0, 1.0);
        float spread = min(sqrt(variance), 0.288675 * (interval.y - interval.x));
        for (int point = -1; point <= 1; point += 2) {
            float y = side * (mean + float(point) * spread);
            vec3 wn = normal_of_slope(slope + y * across);
            vec3 wi = 2.0 * dot(wn, wo) * wn - wo;
            float lit = 0.5 * weight * mass * lit_fraction(visibility, o, direction_area(wi, v.m, cholesky));
            float along = dot(line, vec2(u, y));
            sum += lit * vec3(1.0, along, 0.5 * (along * along - 1.0));
        }
    }
    return LitLine(sum.x, sum.y, sum.z);
}

// What is lit at z standard deviations along the line: a factor of a probe's weight.
float lit_along(LitLine line, float z) {
    return max(line.mean + line.slope * z + line.curve * (z * z - 1.0), 0.0);
}

// Brings probes of this total lit weight to the mean that is lit, 0..1.
float lit_scale(LitLine line, float sum) {
    return line.mean / max(sum, 1e-6);
}

#endif
