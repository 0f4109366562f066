#ifndef LEADR_VISIBLE_FRESNEL_GLSL
#define LEADR_VISIBLE_FRESNEL_GLSL

#include "fresnel.glsl"
#include "visible_slopes.glsl"

// Mean Fresnel reflectance of the facets that wo sees: what a diffuse surface under mirrors does not get. Three facets
// along the slope that is seen, where nearly all of the cosine's variation lies; what lies across it only lengthens N.
vec3 visible_fresnel(vec3 wo, vec2 m, vec3 S, vec3 f0) {
    VisibleSlopes v = visible_slopes(wo, m, S);
    float across = max(v.cov.x + v.cov.y - v.variance * dot(v.axis, v.axis), 0.0);
    vec2 away = sqrt(3.0 * v.variance) * v.axis;
    float mean = 0.0;
    for (int i = -1; i <= 1; ++i) {
        vec2 slope = v.mean + float(i) * away;
        float cosine = max(meso_area(wo, slope), 0.0) * inversesqrt(1.0 + dot(slope, slope) + across);
        mean += (i == 0 ? 2.0 / 3.0 : 1.0 / 6.0) * schlick_weight(cosine);
    }
    return f0 + (grazing_reflectance(f0) - f0) * mean;
}

#endif
