#ifndef LEADR_VISIBLE_FRESNEL_GLSL
#define LEADR_VISIBLE_FRESNEL_GLSL

#include "../facets/complex_index.glsl"
#include "slopes.glsl"

// Three cosines between the viewer and the normals of visible facets, and their weights, which sum to one.
struct VisibleCosines {
    vec3 cosine;
    vec3 weight;
};

// Returns three slopes along the view azimuth whose weights reproduce the first four cumulants of the visible slopes. The slope across this
// azimuth only lengthens N.
VisibleCosines visible_cosines(const VisibleSlopes v) {
    float rest = max(v.S.x + v.S.y - dot(v.axis, v.axis), 0.0);
    float deviation = sqrt(v.variance);
    float skewness = v.third / (v.variance * deviation);
    float reach = sqrt(max(3.0 + v.fourth / (v.variance * v.variance) - 0.75 * skewness * skewness, 0.5));
    vec3 nodes = vec3(0.0, 0.5 * skewness + reach, 0.5 * skewness - reach);
    vec2 of = vec2(0.5, -0.5) / (nodes.yz * reach);
    VisibleCosines c;
    c.weight = vec3(1.0 - of.x - of.y, of);
    for (int i = 0; i < 3; ++i) {
        float u = nodes[i] * deviation;
        vec2 slope = v.mean + v.axis * u;
        c.cosine[i] = (v.facet - v.b * u) * inversesqrt(1.0 + dot(slope, slope) + rest);
    }
    return c;
}

// Returns the mean of Schlick's weight over visible facets.
float mean_schlick_weight(const VisibleCosines c) {
    float mean = 0.0;
    for (int i = 0; i < 3; ++i) {
        mean += c.weight[i] * schlick_weight(c.cosine[i]);
    }
    return clamp(mean, 0.0, 1.0);
}

float visible_schlick_weight(const VisibleSlopes v) {
    return mean_schlick_weight(visible_cosines(v));
}

// Returns the mean of fresnel_deviation over visible facets.
vec3 mean_deviation(const VisibleCosines c, const vec3 f0, const ComplexIndex index) {
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
        mean += c.weight[i] * fresnel_deviation(f0, index, c.cosine[i]);
    }
    return mean;
}

// Returns the mean Fresnel reflectance of the facets visible from wo, which is the fraction of light that does not reach the diffuse base.
vec3 visible_fresnel(const vec3 wo, const vec2 m, const vec3 S, const vec3 f0) {
    return f0 + (grazing_reflectance(f0) - f0) * visible_schlick_weight(visible_slopes(wo, m, S));
}

// Returns the mean of the exact reflectance (fresnel_exact) of the facets visible from wo.
vec3 visible_fresnel_exact(const vec3 wo, const vec2 m, const vec3 S, const vec3 f0, const ComplexIndex index) {
    VisibleCosines c = visible_cosines(visible_slopes(wo, m, S));
    vec3 schlick = f0 + (grazing_reflectance(f0) - f0) * mean_schlick_weight(c);
    return clamp(schlick + mean_deviation(c, f0, index), 0.0, 1.0);
}

#endif
