#ifndef LEADR_RELIEF_COLOR_GLSL
#define LEADR_RELIEF_COLOR_GLSL

#include "../masking/correlated.glsl"
#include "diffuse.glsl"

// Computes the colour of the visible and lit facets, for colours that follow the heights or the slopes of the relief under a pixel
// (derivation in crates/leadr-reflectance/src/visible/relief_color.rs). The inputs are filtered together: the mean colour, `low` and
// `high`, and the covariances `x` and `y` of colour and slope.
//     ReliefColor r = ReliefColor(low, high, x, y);
//     SlopesScore score = lit_slopes_score(wo, wi, m, S);
//     vec3 color = relief_color(mean, r, seen_height(o, lit), slopes_change(r, score, S));

// The visible colour is a mean over facets weighted by (L + 1) u^L. u is the rank of a facet's height, from 0 to 1. L is the sum of the
// Lambdas of viewer and light. The mean is filtered for two values of L.
const float LEADR_RELIEF_COLOR_LOW = 1.0;
const float LEADR_RELIEF_COLOR_HIGH = 4.0;
// The largest L / (L + 2) for which the parabola through both colours is used.
const float LEADR_MOST_SEEN_HEIGHT = 0.8;
// The smallest fraction of the slope variance that remains.
const float LEADR_NARROWEST_SLOPES = 0.1;

struct ReliefColor {
    vec3 low;  // mean with the weights for LEADR_RELIEF_COLOR_LOW, minus the unweighted mean
    vec3 high; // mean with the weights for LEADR_RELIEF_COLOR_HIGH, minus the unweighted mean
    vec3 x;    // covariance of colour with the slope along x
    vec3 y;
};

const ReliefColor LEADR_NO_RELIEF_COLOR = ReliefColor(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));

// Returns L / (L + 2), 0..1, for the visible and lit facets. `lit` is the lit fraction of the visible area: the result of lit_fraction, or
// `open` of a bent normal.
float seen_height(const DirectionArea o, const float lit) {
    float facing = max(o.meso, 0.0) * clamp(lit, 0.0, 1.0);
    return clamp((o.visible - facing) / max(o.visible + facing, 1e-30), 0.0, 1.0);
}

// The shift and the narrowing of the slope distribution when slopes are weighted by visibility or by lighting.
struct SlopesScore {
    vec2 moved;    // S^-1 (mean of the weighted slopes - m); times covariances of colour and slope, it is the change of the mean colour
    vec3 narrowed; // S^-1 (covariance of the weighted slopes - S) S^-1, as xx, yy, xy
};

// Returns (v v^T) as xx, yy, xy.
vec3 outer_square(const vec2 v) {
    return vec3(v.x * v.x, v.y * v.y, v.x * v.y);
}

// Returns the score of the slopes visible from wo.
SlopesScore seen_slopes_score(const vec3 wo, const vec2 m, vec3 S) {
    S = clamp_covariance(S);
    float b = slope_spread(wo, S);
    float a = tilted_area(wo, m, b);
    float per = 1.0 / max(b, 1e-9);
    NormalRamp n = normal_ramp(clamp(a * per, -13.0, 13.0));
    float area = max(clamped_mean(a, b), 1e-3);
    float moved = n.cdf / area;
    return SlopesScore(-moved * wo.xy, (n.pdf * per / area - moved * moved) * outer_square(wo.xy));
}

// Returns the score of the slopes that are visible from wo, weighted by the cosine between their normals and wi.
SlopesScore lit_slopes_score(const vec3 wo, const vec3 wi, vec2 m, vec3 S) {
    S = clamp_covariance(S);
    float ao = tilted_area(wo, m, slope_spread(wo, S));
    float ai = tilted_area(wi, m, slope_spread(wi, S));
    m = face_viewer(wo, m, S, 2.0 * LEADR_VISIBLE_TAIL);
    // One exponential approximates 1/|N| about the mean of |N|^2.
    float t = 0.5 / squared_normal_spread(m, S).x;
    SlopeGaussian g = damped_gaussian(m, S, t);
    vec2 across = vec2(g.S.x * wo.x + g.S.z * wo.y, g.S.z * wo.x + g.S.y * wo.y);
    vec2 along = vec2(g.S.x * wi.x + g.S.z * wi.y, g.S.z * wi.x + g.S.y * wi.y);
    float bo = sqrt(max(dot(across, wo.xy), 0.0)), bi = sqrt(max(dot(along, wi.xy), 0.0));
    float po = 1.0 / max(bo, 1e-9), pi = 1.0 / max(bi, 1e-9);
    ao += 2.0 * t * dot(across, m);
    ai += 2.0 * t * dot(along, m);
    float xo = clamp(ao * po, -13.0, 13.0), xi = clamp(ai * pi, -13.0, 13.0);
    NormalRamp o = normal_ramp(xo), i = normal_ramp(xi);
    float k = dot(across, wi.xy);
    float area_o = max(clamped_mean(ao, bo), 1e-3), area_i = max(clamped_mean(ai, bi), 1e-3);
    // By Stein's lemma, the mean of a slope times a weight is S times the mean of the weight's gradient. The mean of two slopes
    // uses the second derivatives.
    float both = max(area_o * area_i + k * (o.cdf * i.cdf), 0.1 * area_o * area_i);
    float by_o = max(o.cdf * area_i + k * (o.pdf * po) * i.cdf, 0.0);
    float by_i = max(i.cdf * area_o + k * (i.pdf * pi) * o.cdf, 0.0);
    float by_oo = o.pdf * po * max(area_i - k * po * xo * i.cdf, 0.0);
    float by_ii = i.pdf * pi * max(area_o - k * pi * xi * o.cdf, 0.0);
    float by_oi = max(o.cdf * i.cdf + k * (o.pdf * po) * (i.pdf * pi), 0.0);
    vec2 v = (wo.xy * by_o + wi.xy * by_i) / both;
    vec3 mixed = vec3(2.0 * wo.xy * wi.xy, wo.x * wi.y + wo.y * wi.x);
    vec3 h = (by_oo * outer_square(wo.xy) + by_ii * outer_square(wi.xy) + by_oi * mixed) / both - outer_square(v);
    v += 2.0 * t * m;
    // B = (1 + 2 t S)^-1 comes from the exponential. The score is -B v, and the slopes narrow by B h B - 2 t B.
    float tt = 2.0 * t;
    float det = 1.0 + tt * (S.x + S.y + tt * max(S.x * S.y - S.z * S.z, 0.0));
    vec3 B = vec3(1.0 + tt * S.y, 1.0 + tt * S.x, -tt * S.z) / det;
    vec2 first = vec2(B.x * h.x + B.z * h.z, B.x * h.z + B.z * h.y), second = vec2(B.z * h.x + B.y * h.z, B.z * h.z + B.y * h.y);
    vec3 narrowed = vec3(dot(first, B.xz), dot(second, B.zy), dot(first, B.zy)) - tt * B;
    return SlopesScore(vec2(-dot(B.xz, v), -dot(B.zy, v)), narrowed);
}

// Returns the change of the mean colour. A linear regression would be unbounded. If half of the slopes have one colour and half have
// another, the change saturates at the second colour. The change saturates earlier if the remaining slopes are narrow. x and y are the
// components of a score's `moved`, per channel.
vec3 slopes_change(const ReliefColor r, const vec3 x, const vec3 y, const vec3 narrowed, vec3 S) {
    S = clamp_covariance(S);
    vec3 change = r.x * x + r.y * y;
    // The variance of the colours along their regression is C^T S^-1 C, which is at most the variance of colours between 0 and 1.
    vec3 explained = (S.y * r.x * r.x + S.x * r.y * r.y - 2.0 * S.z * r.x * r.y) / max(S.x * S.y - S.z * S.z, 1e-18);
    explained = clamp(explained, 1e-9, 0.25);
    // 1 + part is the ratio of the narrowed to the original slope variance along the regression.
    vec3 part = (narrowed.x * r.x * r.x + narrowed.y * r.y * r.y + 2.0 * narrowed.z * r.x * r.y) / explained;
    vec3 width = inversesqrt(clamp(1.0 + part, LEADR_NARROWEST_SLOPES, 1.0));
    vec3 moved = max(abs(change) * inversesqrt(explained) * width, 1e-2); // the change in standard deviations
    vec3 half_and_half = vec3(normal_ramp(moved.x).cdf, normal_ramp(moved.y).cdf, normal_ramp(moved.z).cdf);
    return change * (width * 1.2533141373 * (2.0 * half_and_half - 1.0) / moved); // sqrt(pi / 2) erf(moved / sqrt(2)) / moved
}

vec3 slopes_change(const ReliefColor r, const SlopesScore score, const vec3 S) {
    return slopes_change(r, vec3(score.moved.x), vec3(score.moved.y), score.narrowed, S);
}

// Returns the colour of the visible and lit facets. height is the result of seen_height, and by_slope is the result of slopes_change.
vec3 relief_color(const vec3 mean, const ReliefColor r, const float height, const vec3 by_slope) {
    float t = min(height, LEADR_MOST_SEEN_HEIGHT);
    vec3 by_height = (9.0 * t * (2.0 / 3.0 - t)) * r.low + (4.5 * t * (t - 1.0 / 3.0)) * r.high;
    return clamp(mean + by_height + by_slope, 0.0, 1.0);
}

#endif
