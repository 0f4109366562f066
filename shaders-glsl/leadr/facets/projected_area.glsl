#ifndef LEADR_PROJECTED_AREA_GLSL
#define LEADR_PROJECTED_AREA_GLSL

#include "../constants.glsl"
#include "normal_distribution.glsl"

// Projected areas of a Gaussian rough surface (LEADR 4.3, in a form without cotangents). w is a unit direction in the tangent frame, whose
// z is the displacement direction. m is the mean slope, and S is the slope covariance (s_xx, s_yy, s_xy).

// Returns a(w), the projected area of the mesosurface per unit of macrosurface. The area is negative when the mesosurface faces away from w
// (LEADR eq. 14).
float meso_area(const vec3 w, const vec2 m) {
    return w.z - dot(w.xy, m);
}

// Returns the square of b(w). b is the standard deviation of the slope along w, times sin(theta) (LEADR eq. 15).
float slope_spread_squared(const vec3 w, const vec3 S) {
    return w.x * w.x * S.x + w.y * w.y * S.y + 2.0 * w.x * w.y * S.z;
}
float slope_spread(const vec3 w, const vec3 S) {
    return sqrt(max(slope_spread_squared(w, S), 0.0));
}

// Returns A(w) - max(a, 0) = b h(|a|/b), the area that is visible only because of the roughness. The result equals a Lambda(w) for a > 0.
float rough_area(const float a, const float b) {
    return b * normal_tail_mean(abs(a) / max(b, 1e-18));
}

// Returns A(w) = a Phi(a/b) + b phi(a/b) = a (1 + Lambda(w)), the visible projected area, which tends to max(a, 0) as b -> 0.
float visible_area(const vec3 w, const vec2 m, const vec3 S) {
    float a = meso_area(w, m);
    return max(a, 0.0) + rough_area(a, slope_spread(w, S));
}

// Returns the mean slope, tilted towards the viewer by the smallest angle at which the slope grid of half extent `lambda` has a visible
// node: a >= 1e-3 - lambda b / 2. The slopes of mesosurfaces that face the viewer do not change. This function replaces the artificial
// micronormal of the supplement, section 3.7. The function is continuous, and makes the smallest possible change of slope.
vec2 face_viewer(const vec3 wo, const vec2 m, const vec3 S, const float lambda) {
    vec2 across = vec2(S.x * wo.x + S.z * wo.y, S.z * wo.x + S.y * wo.y);
    float b2 = max(dot(wo.xy, across), 0.0);
    float deficit = 1e-3 - 0.5 * lambda * sqrt(b2) - meso_area(wo, m);
    // Visible slopes tilt along S wo.xy. If S -> 0, the surface is smooth and tilts along wo.xy.
    vec2 along = across + 1e-6 * wo.xy;
    float gain = b2 + 1e-6 * dot(wo.xy, wo.xy);
    vec2 tilted = m - along * (deficit / max(gain, 1e-12));
    return deficit > 0.0 ? clamp(tilted, -1e6, 1e6) : m;
}

// Returns the change of slope that makes a back-facing mesosurface edge-on, or 0 for a mesosurface that faces the viewer. A pixel with a
// back-facing mesosurface also contains facets that tilt toward the viewer by about the same angle. To include them in the moments:
//     vec2 d = tilt_to_edge(wo, m);  m += d;  S += vec3(d * d, d.x * d.y);
vec2 tilt_to_edge(const vec3 wo, const vec2 m) {
    return wo.xy * (min(meso_area(wo, m), 0.0) / max(dot(wo.xy, wo.xy), 1e-4));
}

// Returns the artificial micronormal of the supplement (3.7). For a mesonormal n that faces away from wo, the result faces wo, nearly edge-on.
// Its weight beside the weights of the other micronormals, which sum to 1, is 1e-5. face_viewer and tilt_to_edge replace it by default.
vec3 artificial_micronormal(const vec3 wo, const vec3 n) {
    return normalize(n - 1.01 * dot(n, wo) * wo);
}

#endif
