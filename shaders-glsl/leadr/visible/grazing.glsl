#ifndef LEADR_VISIBLE_GRAZING_GLSL
#define LEADR_VISIBLE_GRAZING_GLSL

#include "../facets/fresnel.glsl"
#include "../masking/correlated.glsl"
#include "shadowed_specular.glsl"
#include "slopes.glsl"

// Computes the part of a specular lobe that Schlick's weight multiplies. Facets that are nearly edge-on to the viewer dominate this part,
// and few of a rule's nodes lie there, so it has a lookup of its own (crates/leadr-reflectance/src/visible/grazing.rs has the derivation).
// Once per lobe
//     GrazingLobe g = grazing_lobe(shadowing, wo, visible_slopes(wo, m, S), up, base_area, base_variance);
//     reflected += (grazing_reflectance(f0) - f0) * g.weight * fraction lit by the relief * lookup of g.wi, g.variance
// The fraction lit by the relief is the mean of two directions, one standard deviation sqrt(g.spread) above and below g.wi.

struct GrazingLobe {
    float weight;   // mean of Schlick's weight times the lit fraction over the visible facets
    vec3 wi;        // mean direction that these facets reflect, in the tangent frame, unit length
    float variance; // variance of the lookup per axis, in radians squared, below 2
    float spread;   // variance of the directions per axis, in radians squared
};

const int LEADR_GRAZING_NODES = 6;
// Positions and weights of Gauss's rule on 0..1.
const vec2 LEADR_GRAZING_RULE[LEADR_GRAZING_NODES] = vec2[](
    vec2(0.0337652, 0.0856622),
    vec2(0.1693953, 0.1803808),
    vec2(0.3806904, 0.2339570),
    vec2(0.6193096, 0.2339570),
    vec2(0.8306047, 0.1803808),
    vec2(0.9662348, 0.0856622)
);
// The largest deviation of the slopes in the rule, in standard deviations.
const float LEADR_GRAZING_REACH = 3.0;

// Returns the slope, in standard deviations along the view azimuth, of the facets that reflect the horizon of the mesosurface with normal
// `up`. `rest` is the variance across the azimuth.
float horizon_slope(const vec3 wo, const VisibleSlopes v, const vec3 up, const float rest) {
    float height = dot(up, wo);
    float p = up.z - dot(up.xy, v.m), q = dot(up.xy, v.axis);
    float b = v.b * p + v.a * q + height * dot(v.m, v.axis);
    float c = 2.0 * v.a * p - height * (1.0 + dot(v.m, v.m) + rest);
    float a = 2.0 * v.b * q - height * dot(v.axis, v.axis);
    return c / max(b + sqrt(max(b * b - a * c, 0.0)), 1e-6);
}

// base_area has the projected area, at least 0, and the visible area of the mean facet with the roughness of its base. base_variance is the
// slope variance of the base per axis.
GrazingLobe grazing_lobe(const int shadowing, const vec3 wo, const VisibleSlopes v, const vec3 up, const vec2 base_area, const float base_variance) {
    float per_b = 1.0 / max(v.b, 1e-6);
    float nu = v.a * per_b;
    float rest = max(v.S.x + v.S.y - dot(v.axis, v.axis), 0.0);
    // Given u, the slopes vary orthogonally to the azimuth.
    vec2 aside = vec2(-wo.y, wo.x) * sqrt(rest / max(dot(wo.xy, wo.xy), 1e-12));
    float highest = min(min(nu, horizon_slope(wo, v, up, rest)), LEADR_GRAZING_REACH);
    float lowest = min(-LEADR_GRAZING_REACH, highest - LEADR_GRAZING_REACH);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < LEADR_GRAZING_NODES; ++i) {
        float u = lowest + (highest - lowest) * LEADR_GRAZING_RULE[i].x;
        vec2 slope = v.m + v.axis * u;
        float per = 1.0 / (1.0 + dot(slope, slope) + rest);
        float facet = max(v.a - v.b * u, 0.0);
        // A facet one standard deviation to the side has the mean height of the reflected directions.
        vec3 beside = vec3(-slope - aside, 1.0);
        vec3 wi = 2.0 * max(dot(wo, beside), 0.0) * per * beside - wo;
        float weight = LEADR_GRAZING_RULE[i].y * exp(-0.5 * u * u) * max(nu - u, 0.0) * schlick_weight(facet * sqrt(per))
                     * round_lit_fraction(shadowing, wo, base_area.x, base_area.y, wi, v.m, base_variance);
        sum += weight * vec4(2.0 * facet * per * vec3(-slope, 1.0) - wo, 1.0);
    }
    GrazingLobe g;
    g.weight = min(sum.w * (highest - lowest) * 0.39894228 / max(v.area * per_b, 1e-9), 1.0);
    // The length of the mean direction gives the variance.
    float square = dot(sum.xyz, sum.xyz);
    g.wi = sum.xyz * inversesqrt(max(square, 1e-30));
    g.spread = -0.5 * log(clamp(square / max(sum.w * sum.w, 1e-30), 1e-4, 1.0));
    float variance = g.spread / (1.0 + 0.5 * g.spread);
    float widest = max(dot(up, g.wi), 0.0) / LEADR_HORIZON_DEVIATIONS;
    g.variance = clamp(widest * widest, LEADR_NARROWEST * variance, variance);
    return g;
}

#endif
