#ifndef LEADR_VISIBLE_SLOPES_GLSL
#define LEADR_VISIBLE_SLOPES_GLSL

#include "../facets/projected_area.glsl"
#include "../slopes/statistics.glsl"

// Computes the visible slopes of a Gaussian surface in closed form. u is the slope in the direction of wo, in standard deviations. Along u,
// the density of visible slopes is a clamped line times a normal density. Across u, the density stays Gaussian.

// The largest rotation of a mesosurface beyond its silhouette, in units of slope_spread. At larger rotations, almost none of the surface is
// visible (0.8 % of slope_spread), so the surface is tilted back.
const float LEADR_VISIBLE_TAIL = 2.0;

struct VisibleSlopes {
    vec2 m;         // mean slope, tilted back if it exceeds LEADR_VISIBLE_TAIL
    vec3 S;         // covariance of the slopes, bounded
    float a;        // projected area of the mesosurface
    float b;        // spread of the slope along wo
    float area;     // visible area, > 0
    vec2 axis;      // change of slope per unit of u; u = wo.xy . (slope - m) / b
    float shift;    // minus the mean of u over the visible facets, >= 0
    vec2 mean;      // mean of the visible slopes
    vec3 cov;       // covariance of the visible slopes
    float facet;    // projected area of the facet with the mean visible slope, > 0
    float variance; // variance of u over the visible facets, 0..1
    float third;    // third central moment of u over the visible facets, <= 0
    float fourth;   // fourth cumulant of u over the visible facets
};

// The moments of u over the visible facets.
struct VisibleCumulants {
    float shift;    // minus the mean, >= 0
    float variance; // 0..1
    float third;    // third central moment, <= 0
    float fourth;   // fourth cumulant
};

// Returns the moments of the density max(0, nu - u) times the normal density. n belongs to nu.
VisibleCumulants visible_cumulants(const float nu, const NormalRamp n) {
    VisibleCumulants c;
    float per_ramp = 1.0 / n.ramp;
    float excess = n.pdf * per_ramp; // second moment of u, minus one
    c.shift = n.cdf * per_ramp;
    float shift2 = c.shift * c.shift;
    c.variance = clamp(1.0 + excess - shift2, 0.02, 1.0);
    float third = nu * excess - 3.0 * c.shift; // third moment of u
    c.third = min(third + c.shift * (3.0 + 3.0 * excess - 2.0 * shift2), 0.0);
    float fourth = 3.0 + (min(nu * nu, 1e6) + 5.0) * excess;
    c.fourth = fourth + 4.0 * c.shift * third + shift2 * (6.0 + 6.0 * excess - 3.0 * shift2) - 3.0 * c.variance * c.variance;
    return c;
}

// Returns the projected area of a mesosurface after tilting it back to LEADR_VISIBLE_TAIL. m is the mean slope before the tilt.
float tilted_area(const vec3 wo, const vec2 m, const float b) {
    return max(meso_area(wo, m), 1e-3 - LEADR_VISIBLE_TAIL * b);
}

// Returns the exact moments of the density P22 max(0, a - b u) / A. S is the slope covariance, and may have any value.
VisibleSlopes visible_slopes(const vec3 wo, vec2 m, vec3 S) {
    VisibleSlopes v;
    v.S = clamp_covariance(S);
    v.m = face_viewer(wo, m, v.S, 2.0 * LEADR_VISIBLE_TAIL);
    vec2 across = vec2(v.S.x * wo.x + v.S.z * wo.y, v.S.z * wo.x + v.S.y * wo.y);
    v.b = sqrt(max(dot(across, wo.xy), 0.0));
    v.a = tilted_area(wo, m, v.b);
    float per_b = 1.0 / max(v.b, 1e-18);
    float nu = v.a * per_b;
    NormalRamp n = normal_ramp(nu);
    v.axis = across * per_b;
    v.area = v.b > 1e-18 ? v.b * n.ramp : max(v.a, 0.0);
    VisibleCumulants u = visible_cumulants(nu, n);
    v.shift = u.shift;
    v.variance = u.variance;
    v.third = u.third;
    v.fourth = u.fourth;
    v.mean = v.m - v.axis * v.shift;
    v.facet = v.a + v.b * v.shift;
    v.cov = v.S - (1.0 - v.variance) * vec3(v.axis * v.axis, v.axis.x * v.axis.y);
    return v;
}

#endif
