#ifndef LEADR_VISIBLE_FRESNEL_GLSL
#define LEADR_VISIBLE_FRESNEL_GLSL

#include "../facets/fresnel.glsl"
#include "slopes.glsl"

// Returns the mean of Schlick's weight over visible slopes. The mean is taken over three slopes along the view azimuth whose weights
// reproduce the first four cumulants. The slope across this azimuth only lengthens N.
float visible_schlick_weight(const VisibleSlopes v) {
    float rest = max(v.S.x + v.S.y - dot(v.axis, v.axis), 0.0);
    float deviation = sqrt(v.variance);
    float skewness = v.third / (v.variance * deviation);
    float reach = sqrt(max(3.0 + v.fourth / (v.variance * v.variance) - 0.75 * skewness * skewness, 0.5));
    vec3 nodes = vec3(0.0, 0.5 * skewness + reach, 0.5 * skewness - reach);
    vec2 of = vec2(0.5, -0.5) / (nodes.yz * reach);
    vec3 weights = vec3(1.0 - of.x - of.y, of);
    float mean = 0.0;
    for (int i = 0; i < 3; ++i) {
        float u = nodes[i] * deviation;
        vec2 slope = v.mean + v.axis * u;
        mean += weights[i] * schlick_weight((v.facet - v.b * u) * inversesqrt(1.0 + dot(slope, slope) + rest));
    }
    return clamp(mean, 0.0, 1.0);
}

// Returns the mean Fresnel reflectance of the facets visible from wo, which is the fraction of light that does not reach the diffuse base.
vec3 visible_fresnel(const vec3 wo, const vec2 m, const vec3 S, const vec3 f0) {
    return f0 + (grazing_reflectance(f0) - f0) * visible_schlick_weight(visible_slopes(wo, m, S));
}

#endif
