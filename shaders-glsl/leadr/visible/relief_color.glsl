#ifndef LEADR_RELIEF_COLOR_GLSL
#define LEADR_RELIEF_COLOR_GLSL

#include "../masking/correlated.glsl"
#include "diffuse.glsl"

// The colour of what is seen and lit, where colours follow the heights or the slopes of the relief under a pixel;
// src/reflectance/visible/relief_color.rs derives it. With the mean colour, `low` and `high` filtered beside it, and the covariances
// of colour and slope `x` and `y`:
//     ReliefColor r = ReliefColor(low, high, x, y);
//     vec3 color = relief_color(mean, r, seen_height(o, lit), held_score(lit_slopes_score(wo, wi, m, S), S));

// A mean over facets weighted by (L + 1) u^L, u the rank of their height from 0 to 1, is what is seen where L is the sum of both
// Lambdas. It is filtered for two of them.
const float LEADR_RELIEF_COLOR_LOW = 1.0;
const float LEADR_RELIEF_COLOR_HIGH = 4.0;
// L / (L + 2) up to which the parabola through both follows the colour.
const float LEADR_MOST_SEEN_HEIGHT = 0.8;

struct ReliefColor {
    vec3 low;  // mean weighted for LEADR_RELIEF_COLOR_LOW, minus the mean
    vec3 high; // and for LEADR_RELIEF_COLOR_HIGH
    vec3 x;    // covariance with the slope along x
    vec3 y;
};

const ReliefColor LEADR_NO_RELIEF_COLOR = ReliefColor(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));

// L / (L + 2), 0..1, of what is seen and lit. lit: share of the visible area that is lit (lit_fraction, or `open` of a bent normal).
float seen_height(DirectionArea o, float lit) {
    float facing = max(o.meso, 0.0) * clamp(lit, 0.0, 1.0);
    return clamp((o.visible - facing) / max(o.visible + facing, 1e-30), 0.0, 1.0);
}

// S^-1 (mean of the visible slopes - m): times a covariance with the slopes it is the change of a mean.
vec2 seen_slopes_score(vec3 wo, vec2 m, vec3 S) {
    S = clamp_covariance(S);
    float b = slope_spread(wo, S);
    float a = tilted_area(wo, m, b);
    NormalRamp n = normal_ramp(a / max(b, 1e-18));
    return wo.xy * (-n.cdf / max(clamped_mean(a, b), 1e-3));
}

// The same for slopes seen from wo and weighted by the cosine of the light from wi on them.
vec2 lit_slopes_score(vec3 wo, vec3 wi, vec2 m, vec3 S) {
    S = clamp_covariance(S);
    float ao = tilted_area(wo, m, slope_spread(wo, S));
    float ai = tilted_area(wi, m, slope_spread(wi, S));
    m = face_viewer(wo, m, S, 2.0 * LEADR_VISIBLE_TAIL);
    // 1/|N| as one exponential about the mean of |N|^2.
    float t = 0.5 / squared_normal_spread(m, S).x;
    SlopeGaussian g = damped_gaussian(m, S, t);
    vec2 across = vec2(g.S.x * wo.x + g.S.z * wo.y, g.S.z * wo.x + g.S.y * wo.y);
    vec2 along = vec2(g.S.x * wi.x + g.S.z * wi.y, g.S.z * wi.x + g.S.y * wi.y);
    float bo = sqrt(max(dot(across, wo.xy), 0.0)), bi = sqrt(max(dot(along, wi.xy), 0.0));
    float po = 1.0 / max(bo, 1e-9), pi = 1.0 / max(bi, 1e-9);
    ao += 2.0 * t * dot(across, m);
    ai += 2.0 * t * dot(along, m);
    NormalRamp o = normal_ramp(clamp(ao * po, -13.0, 13.0)), i = normal_ramp(clamp(ai * pi, -13.0, 13.0));
    float k = dot(across, wi.xy);
    float area_o = max(clamped_mean(ao, bo), 1e-3), area_i = max(clamped_mean(ai, bi), 1e-3);
    // Stein's lemma: the mean of a slope times a weight is S times the mean of the weight's gradient.
    float both = max(area_o * area_i + k * (o.cdf * i.cdf), 0.1 * area_o * area_i);
    float by_o = max(o.cdf * area_i + k * (o.pdf * po) * i.cdf, 0.0);
    float by_i = max(i.cdf * area_o + k * (i.pdf * pi) * o.cdf, 0.0);
    vec2 v = 2.0 * t * m + (wo.xy * by_o + wi.xy * by_i) / both;
    // (1 + 2 t S)^-1
    float tt = 2.0 * t;
    float det = 1.0 + tt * (S.x + S.y + tt * max(S.x * S.y - S.z * S.z, 0.0));
    return vec2(S.z * v.y * tt - (1.0 + tt * S.y) * v.x, S.z * v.x * tt - (1.0 + tt * S.x) * v.y) / det;
}

// The part of a score by which no colour leaves those that there are. Regression goes on for ever; where a half of all slopes has one
// colour and the other half another, the change of the mean ends as that half ends.
float held_part(vec2 score, vec3 S) {
    S = clamp_covariance(S);
    float square = S.x * score.x * score.x + S.y * score.y * score.y + 2.0 * S.z * score.x * score.y;
    float moved = clamp(sqrt(max(square, 0.0)), 1e-2, 13.0); // deviations
    return 1.2533141373 * (2.0 * normal_ramp(moved).cdf - 1.0) / moved; // sqrt(pi / 2) erf(moved / sqrt(2)) / moved
}

vec2 held_score(vec2 score, vec3 S) {
    return score * held_part(score, S);
}

// height: of seen_height; score: of held_score.
vec3 relief_color(vec3 mean, ReliefColor r, float height, vec2 score) {
    float t = min(height, LEADR_MOST_SEEN_HEIGHT);
    vec3 by_height = (9.0 * t * (2.0 / 3.0 - t)) * r.low + (4.5 * t * (t - 1.0 / 3.0)) * r.high;
    return clamp(mean + by_height + score.x * r.x + score.y * r.y, 0.0, 1.0);
}

#endif
