#ifndef LEADR_LIT_SLOPES_GLSL
#define LEADR_LIT_SLOPES_GLSL

#include "slopes.glsl"

// Computes the visible slopes whose facets reflect lit directions. A facet reflects a direction above the mesosurface's horizon if its
// slope lies within a conic. The weight exp(-lean.x - x D x / 2) replaces the conic, where x is the slope relative to the mean. The weight
// falls as the reflected direction approaches the horizon, faster for rougher surfaces. The product of the weight and the Gaussian density
// of slopes is another Gaussian (crates/leadr-reflectance/src/visible/lit_slopes.rs).

// LEADR_LIT_FALL is -ln of the ratio of two weights: of a direction at the horizon, and of the highest direction. The constant applies to a
// very rough surface seen from straight above. LEADR_LIT_HALF is the mean slope variance per axis at which half of the fall applies.
// LEADR_LIT_LEAN is the ratio of the linear to the quadratic term.
const float LEADR_LIT_FALL = 1.35;
const float LEADR_LIT_HALF = 0.2;
const float LEADR_LIT_LEAN = 0.65;

struct LitSlopes {
    vec2 m;     // mean of the weighted slopes of all facets
    vec3 S;     // covariance of the weighted slopes
    vec2 lean;  // linear coefficient of the weight's exponent
    vec3 damp;  // quadratic coefficient D of the exponent: xx, yy, xy
    float mean; // logarithm of the mean weight
};

// Returns the weighted slopes, from the result of visible_slopes.
LitSlopes lit_slopes(const vec3 wo, const VisibleSlopes v) {
    vec2 m = v.m;
    vec3 S = v.S;
    float per = 1.0 / (1.0 + dot(m, m));
    float height = max(v.a, 0.0) * sqrt(per);
    float r = (0.5 / LEADR_LIT_HALF) * (S.x + S.y);
    float k = 2.0 * LEADR_LIT_FALL * height * sqrt(per) * (r * r / (1.0 + r * r));
    LitSlopes lit;
    lit.lean = (LEADR_LIT_LEAN * k * sqrt(height)) * wo.xy;
    // If the conic is not an ellipse, only the direction along which it is flat is kept.
    float even = max(wo.z, 0.0);
    float across = dot(wo.xy, m);
    float part = even / max(max(length(wo.xy) * length(m), even), 1e-9);
    vec3 bend = part * vec3(2.0 * wo.xy * m - across, wo.x * m.y + wo.y * m.x);
    lit.damp = (k * per) * (vec3(even, even, 0.0) + bend);
    // lit.S is (S^-1 + D)^-1.
    vec3 D = lit.damp;
    float det = max(S.x * S.y - S.z * S.z, 0.0);
    float both = det * max(D.x * D.y - D.z * D.z, 0.0);
    float share = 1.0 / (1.0 + S.x * D.x + S.y * D.y + 2.0 * S.z * D.z + both);
    lit.S = share * (S + det * vec3(D.yx, -D.z));
    vec2 moved = -vec2(dot(lit.S.xz, lit.lean), dot(lit.S.zy, lit.lean));
    // The factor limits the shift of the mean where the conic is flat and the slopes along it are steep.
    float bound = inversesqrt(max(1.0 - 2.0 * dot(lit.lean, moved), 1.0));
    lit.lean *= bound;
    moved *= bound;
    lit.m = m + moved;
    lit.mean = 0.5 * (log(share) - dot(lit.lean, moved));
    return lit;
}

// Returns -ln of the weight at x from the mean slope.
float lit_share(const LitSlopes lit, const vec2 x) {
    vec3 D = lit.damp;
    return dot(lit.lean, x) + 0.5 * (D.x * x.x * x.x + D.y * x.y * x.y) + D.z * x.x * x.y;
}

#endif
