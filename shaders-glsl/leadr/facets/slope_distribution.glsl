#ifndef LEADR_SLOPE_DISTRIBUTION_GLSL
#define LEADR_SLOPE_DISTRIBUTION_GLSL

// Returns max(0, wo.wn) d / area, the density of visible normals (thesis eq. 2.17), where d = D(wn) and area = A(wo). The
// result is finite, at most 1e37; an area below 1e-26 is treated as 1e-26.
float visible_density(const vec3 wo, const vec3 wn, const float d, const float area) {
    float ratio = max(dot(wo, wn), 0.0) / max(area, 1e-26);
    return ratio * min(d, 1e37 / max(ratio, 1.0));
}

#endif
