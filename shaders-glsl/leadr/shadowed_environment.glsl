#ifndef LEADR_SHADOWED_ENVIRONMENT_GLSL
#define LEADR_SHADOWED_ENVIRONMENT_GLSL

#include "correlated_masking.glsl"
#include "frame.glsl"
#include "sh.glsl"
#include "slope_grid.glsl"

// Diffuse environments with the shadows that the surface throws on itself, one irradiance lookup; src/reflectance/shadowed_environment.rs derives it.

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

#endif
