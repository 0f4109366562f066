#ifndef LEADR_SHADOWED_SPECULAR_GLSL
#define LEADR_SHADOWED_SPECULAR_GLSL

#include "../facets/fresnel.glsl"
#include "../masking/correlated.glsl"
#include "horizon.glsl"
#include "specular.glsl"

// Computes specular environments with self-shadowing of the surface, for rules with few probes
// (crates/leadr-reflectance/src/visible/shadowed_specular.rs). Once per pixel
//     VisibleProbes probes = visible_probes(shadowing, wo, m, S, probe_kernel(n));
//     DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
// and for each probe
//     LitProbe l = lit_probe(shadowing, probes, o, wo, mean of f0, p); or with the horizon of larger bumps: (…, p, true, horizon)
//     reflected += p.weight * (f0 * l.lit + (grazing_reflectance(f0) - f0) * l.grazing) * lookup of l.wi, l.narrowing * p.variance
//     lit += p.weight * l.lit
// and finally reflected /= max(lit, 1.0), so that errors of the lit fractions add no energy.

struct LitProbe {
    float lit;       // lit fraction of the probe, times the ratio between the probe's fraction of the visible facets and its weight
    float grazing;   // the value `lit`, weighted by Schlick's term
    vec3 wi;         // direction of the probe's environment lookup, of any length
    float narrowing; // factor on the variance of the lookup, 0.1..1
};

// The largest logarithm of the ratio between a probe's fraction of the visible facets and its weight. Only directions next to the horizon
// come close to this limit, and none of their facets is lit.
const float LEADR_MOST_SHARE = 4.0;

// A probe is split into two directions. Each keeps this fraction of the probe's standard deviation.
const float LEADR_HALF_DEVIATION = 0.5;

// The factor on the horizon's excess for specular reflection. Visible specular facets reflect lower parts of the environment than the
// average facet, and there the jagged true horizon hides more. The value is fitted to images (theory, section 10).
const float LEADR_SPECULAR_HORIZON = 1.2;

// The smallest distance of the horizon of the mesosurface from the lookup direction, in standard deviations of the kernel. A wider kernel
// would reach light from below the mesosurface, which no facet reflects.
const float LEADR_HORIZON_DEVIATIONS = 2.0;

// The smallest factor on the variance of the lookup.
const float LEADR_NARROWEST = 0.1;

// Returns the lit fraction of a direction, and the lit fraction weighted by Schlick's term. If `relief` is true, the horizon h also shadows
// light whose standard deviation is `deviation`.
vec2 lit_direction(const int shadowing, const VisibleProbes probes, const DirectionArea o, const vec3 wo, const vec3 w, const bool relief,
                   const Horizon h, const float deviation) {
    vec3 middle = wo + w;
    float share = probes.lit.mean + lit_share(probes.lit, middle.xy / -max(middle.z, 1e-4) - probes.m);
    float lit = lit_fraction(shadowing, o, direction_area(w, probes.m, probes.cholesky)) * exp(min(share, LEADR_MOST_SHARE));
    if (relief) {
        lit *= horizon_visibility(w, probes.m, h, deviation);
    }
    return lit * vec2(1.0, schlick_weight(sqrt(max(0.5 + 0.5 * dot(wo, w), 0.0))));
}

// Two directions for light from about a direction, one deviation above and one deviation below it relative to the mesosurface.
struct ProbeDirections {
    vec3 up;   // normal of the mesosurface
    vec3 high;
    vec3 low;
};

// Returns the two directions for w, of unit length. variance is that of the light per axis.
ProbeDirections split_direction(const vec3 up, const vec3 w, const float variance) {
    float height = dot(up, w);
    float side = sqrt(max(1.0 - height * height, 0.0));
    float per_side = 1.0 / max(side, 1e-4);
    float cosine2 = 1.0 / (1.0 + variance);
    float sine = sqrt(variance * cosine2);
    vec2 heights = height * cosine2 + vec2(side * sine, -side * sine);
    vec2 sides = per_side * sqrt(max(1.0 - heights * heights, 0.0));
    vec3 flat_wi = w - up * height;
    return ProbeDirections(up, up * heights.x + flat_wi * sides.x, up * heights.y + flat_wi * sides.y);
}

ProbeDirections probe_directions(const VisibleProbes probes, const VisibleProbe p) {
    vec3 up = vec3(-probes.m, 1.0) * inversesqrt(1.0 + dot(probes.m, probes.m));
    return split_direction(up, p.mirror, probes.lit_spread * p.variance);
}

// Returns the lit part of a probe. The result is the mean of its two directions. Each direction has its own lit fraction, weight and Fresnel
// term. The lookup moves and narrows to the lit part. `also` has further factors on the lit fractions of both directions. If `relief` is
// true, the horizon h of larger bumps also shadows the probe.
LitProbe lit_probe(const int shadowing, const VisibleProbes probes, const DirectionArea o, const vec3 wo, const float f0, VisibleProbe p,
                   const ProbeDirections d, const vec2 also, const bool relief, Horizon h) {
    p.wi *= inversesqrt(max(dot(p.wi, p.wi), 1e-12));
    h = raised_horizon(h, LEADR_SPECULAR_HORIZON);
    float deviation = LEADR_HALF_DEVIATION * sqrt(p.variance);
    vec2 high = also.x * lit_direction(shadowing, probes, o, wo, d.high, relief, h, deviation);
    vec2 low = also.y * lit_direction(shadowing, probes, o, wo, d.low, relief, h, deviation);
    float above = mix(high.y, high.x, f0);
    float below = mix(low.y, low.x, f0);
    float bias = (above - below) / max(above + below, 1e-6);
    vec3 rise = d.up - p.wi * dot(d.up, p.wi);
    vec3 towards = p.wi + rise * (bias * sqrt(p.variance) * inversesqrt(max(dot(rise, rise), 1e-8)));
    float widest = max(dot(d.up, towards), 0.0) * inversesqrt(max(dot(towards, towards), 1e-12)) / LEADR_HORIZON_DEVIATIONS;
    float narrowing = clamp(widest * widest / max(p.variance, 1e-12), LEADR_NARROWEST, 1.0 - 0.5 * bias * bias);
    vec2 both = 0.5 * (high + low);
    return LitProbe(both.x, both.y, towards, narrowing);
}

// Returns the same for one Gaussian of slopes.
LitProbe lit_probe(const int shadowing, const VisibleProbes probes, const DirectionArea o, const vec3 wo, const float f0, VisibleProbe p,
                   const bool relief, Horizon h) {
    if (shadowing == LEADR_SHADOWING_NONE && !relief) return LitProbe(1.0, schlick_weight(p.cosine), p.wi, 1.0);
    return lit_probe(shadowing, probes, o, wo, f0, p, probe_directions(probes, p), vec2(1.0), relief, h);
}

LitProbe lit_probe(const int shadowing, const VisibleProbes probes, const DirectionArea o, const vec3 wo, const float f0,
                   const VisibleProbe p) {
    return lit_probe(shadowing, probes, o, wo, f0, p, false, Horizon(vec2(0.0), vec3(0.0)));
}

#endif
