#ifndef LEADR_SHADOWED_ENVIRONMENT_GLSL
#define LEADR_SHADOWED_ENVIRONMENT_GLSL

#include "../fma.glsl"
#include "../frame.glsl"
#include "../facets/projected_area.glsl"
#include "../integrals/sh.glsl"
#include "../slopes/grid.glsl"

// Computes diffuse environments with self-shadowing of the surface, from one irradiance lookup.
// crates/leadr-reflectance/src/visible/shadowed_environment.rs has the derivation.

// The tilt of the visible part of the mesosurface.
struct VisibleTilt {
    vec2 shift;  // mean of the visible slopes minus the mean slope of all facets; exact
    float front; // a / A, 0..1, or 0 for a mesosurface that faces away
};

// Returns the tilt, with the shift -S wo.xy Phi(t) / A, where t = a / b and A = b (t Phi(t) + phi(t)).
VisibleTilt visible_tilt(const vec3 wo, const vec2 m, const vec3 S) {
    vec2 across = vec2(S.x * wo.x + S.z * wo.y, S.z * wo.x + S.y * wo.y);
    float per_b = inversesqrt(max(dot(across, wo.xy), 1e-24));
    float t = clamp(meso_area(wo, m) * per_b, -1e6, 1e6);
    ClampedLine line = clamped_line(t);
    return VisibleTilt(clamp(across * (-line.lean * per_b), -1e3, 1e3), line.front);
}

// The unoccluded part of the environment for a self-shadowed diffuse surface.
struct BentNormal {
    vec3 normal; // direction of the irradiance lookup, unit length, in the tangent frame
    float open;  // factor on the irradiance of the lookup, 0..1
};

// Returns the bent normal. S is the slope covariance, which must be usable (clamp_covariance).
BentNormal bent_normal(const vec3 wo, const vec2 m, const vec3 S) {
    VisibleTilt v = visible_tilt(wo, m, S);
    float iq = 1.0 / (1.0 + dot(m, m));
    float tau = 0.5 * iq * (S.x + S.y);
    float det = iq * sqrt(max(fma(S.x, S.y, -S.z * S.z), 0.0));
    float ao = max(meso_area(wo, m), 0.0);
    float spread = 1.0 + 0.89 * sqrt(tau + 1.2 * max(tau - det, 0.0));
    float lost = 1.10 * tau / (spread + 1.10 * tau);
    float open = 1.0 - lost * (0.67 + 0.33 * v.front) + 0.19 * dot(v.shift, m) * iq;
    float grazing = 1.0 - ao * ao * iq, sigma = sqrt(tau);
    float bend = (1.0 + 0.38 * sigma * grazing * grazing) / (1.0 + 2.25 * tau / (sigma + 0.22));
    return BentNormal(normal_of_slope(m + bend * v.shift), clamp(open, 0.0, 1.0));
}

// Returns the diffuse radiance under an environment, with shadows, per unit of albedo. c has the coefficients of the radiance in world
// space, and f is the tangent frame in world space. `rest` is the irradiance of orders above 2 at v.normal, or 0.
vec3 shadowed_diffuse_environment(const BentNormal v, const Frame f, const vec3 c[9], const vec3 rest) {
    return max(sh_irradiance(c, from_frame(f, v.normal)) + rest, 0.0) * (v.open / LEADR_PI);
}

#endif
