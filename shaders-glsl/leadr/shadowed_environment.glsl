#ifndef LEADR_SHADOWED_ENVIRONMENT_GLSL
#define LEADR_SHADOWED_ENVIRONMENT_GLSL

#include "correlated_masking.glsl"
#include "frame.glsl"
#include "sh.glsl"
#include "slope_grid.glsl"

// Environments with the shadows that the surface throws on itself; src/reflectance/shadowed_environment.rs derives it.

// Phi(t) / (t Phi(t) + phi(t)): how far, in standard deviations, what is visible tilts towards the viewer.
float visible_tilt(float t) {
    float x = t < 0.0 ? min(-t, 13.0) : t;
    float mills = mills_ratio(x);
    if (t < 0.0) return mills / tail_mean_ratio(x);
    float pdf = normal_pdf(x);
    float cdf = 1.0 - pdf * mills;
    return cdf / (t * cdf + pdf);
}

// Mean slope of what the viewer sees, minus the mean slope. Exact.
vec2 visible_slope_shift(DirectionArea o, vec3 cholesky) {
    float inverse = 1.0 / max(o.spread, 1e-12);
    float tilt = visible_tilt(clamp(o.meso * inverse, -1e6, 1e6));
    vec2 along = o.whitened * (-tilt * inverse);
    return clamp(vec2(cholesky.x * along.x, cholesky.y * along.x + cholesky.z * along.y), -1e3, 1e3);
}

// What a shadowed diffuse surface shows of an environment.
struct BentNormal {
    vec3 normal; // unit, tangent frame: where to look the irradiance up
    float open;  // factor of that irradiance, 0..1
};

BentNormal bent_normal(DirectionArea o, vec2 m, vec3 cholesky) {
    float iq = 1.0 / (1.0 + dot(m, m));
    float tau = 0.5 * iq * dot(cholesky, cholesky);
    float det = iq * cholesky.x * cholesky.z;
    float ao = max(o.meso, 0.0);
    float g1 = ao / max(o.visible, 1e-30);
    vec2 shift = visible_slope_shift(o, cholesky);
    float x = 1.10 * tau / (1.0 + 0.89 * sqrt(tau + 1.2 * max(tau - det, 0.0)));
    float open = 1.0 - x / (1.0 + x) * (0.67 + 0.33 * g1) + 0.19 * dot(shift, m) * iq;
    float bend = 0.67 * (1.0 + 0.6 * (1.0 - ao * ao * iq)) / (1.0 + 1.2 * sqrt(tau));
    return BentNormal(normal_of_slope(m + bend * shift), clamp(open, 0.0, 1.0));
}

// Diffuse radiance under an environment, with shadows, per unit of albedo. c: radiance coefficients in the world; f: the
// tangent frame in the world.
vec3 shadowed_diffuse_environment(BentNormal v, Frame f, vec3 c[9]) {
    return max(sh_irradiance(c, from_frame(f, v.normal)), 0.0) * (v.open / LEADR_PI);
}

// The interval of y where a2 y^2 + b2 y + c2 > 0, within +-8; empty (x >= y) if nowhere. Of a parabola that opens upwards
// its tangent line at 0.
vec2 positive_interval(float a2, float b2, float c2) {
    a2 = min(a2, 0.0);
    float discriminant = b2 * b2 - 4.0 * a2 * c2;
    if (discriminant <= 0.0) return c2 > 0.0 ? vec2(-8.0, 8.0) : vec2(8.0);
    float side = b2 < 0.0 ? -1.0 : 1.0;
    float k = b2 + side * sqrt(discriminant);
    float near = clamp(-2.0 * c2 / k, -8.0, 8.0);
    float far = -a2 * 16.0 > abs(k) ? -0.5 * k / a2 : 8.0 * side;
    return vec2(min(near, far), max(near, far));
}

// Part of a probe that the environment reaches, 0..1: a factor of its weight in a sum that is normalised for masking. The
// probe at `slope` stands for all slopes `slope + y across`, y ~ N(0, 1); across 0: for itself alone. Where a rule blurs
// its probes and moves them together for it, this wants the slopes that they stand for, spread over all that is visible;
// the radiance is fetched where the rule has its probe.
float lit_probe(int visibility, DirectionArea o, vec3 wo, vec2 slope, vec2 across, vec2 m, vec3 cholesky) {
    if (visibility == LEADR_VISIBILITY_MASKING) return 1.0;
    // Reflections above the mesosurface: an interval of y.
    float v = wo.z - dot(wo.xy, slope);
    float dv = -dot(wo.xy, across);
    float k = 1.0 + dot(slope, m);
    float dk = dot(across, m);
    float ao = max(o.meso, 0.0);
    vec2 interval = positive_interval(2.0 * dv * dk - ao * dot(across, across),
                                      2.0 * (v * dk + dv * k - ao * dot(slope, across)),
                                      2.0 * v * k - ao * (1.0 + dot(slope, slope)));
    if (interval.x >= interval.y) return 0.0;
    // Mass, mean and standard deviation of the normal density over it, from the side where the tail is small.
    float side = interval.x + interval.y > 0.0 ? -1.0 : 1.0;
    if (side < 0.0) interval = -interval.yx;
    float pl = normal_pdf(interval.x);
    float ph = normal_pdf(interval.y);
    float mass = max(normal_cdf(interval.y) - normal_cdf(interval.x), 1e-6);
    float mean = clamp((pl - ph) / mass, interval.x, interval.y);
    float variance = clamp(1.0 + (interval.x * pl - interval.y * ph) / mass - mean * mean, 0.0, 1.0);
    float sd = min(sqrt(variance), 0.288675 * (interval.y - interval.x));
    float lit = 0.0;
    for (int point = -1; point <= 1; point += 2) {
        vec3 wn = normal_of_slope(slope + side * (mean + float(point) * sd) * across);
        vec3 wi = 2.0 * dot(wn, wo) * wn - wo;
        lit += lit_fraction(visibility, o, direction_area(wi, m, cholesky));
    }
    return 0.5 * mass * lit;
}

#endif
