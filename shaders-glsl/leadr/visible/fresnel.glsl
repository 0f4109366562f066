#ifndef LEADR_VISIBLE_FRESNEL_GLSL
#define LEADR_VISIBLE_FRESNEL_GLSL

#include "../facets/fresnel.glsl"
#include "slopes.glsl"

// Returns the mean of Schlick's weight over slopes that vary along `axis` about `slope`. `facet` is the projected area of the facet at
// `slope`, and b is the decrease of this area per standard deviation. `rest` is the variance across the axis. `variance` is the variance
// along the axis, in squares of the length of `axis`.
float mean_schlick_weight(const float facet, const float b, const vec2 axis, const vec2 slope, const float rest, const float variance) {
    float stretch = dot(axis, axis);
    float per = inversesqrt(1.0 + dot(slope, slope) + rest);
    // At d standard deviations of the slope along the viewer's direction, the cosine is (facet - b d) / |N|.
    float cosine = facet * per;
    float loss = b * per;
    float turn = dot(slope, axis) * per * per;
    float first = loss + cosine * turn;
    float second = loss * turn + cosine * (1.5 * turn * turn - 0.5 * stretch * per * per);
    float k = clamp(1.0 - cosine - variance * second, 0.0, 1.0);
    float k2 = k * k, v = variance * first * first;
    return min(k * (k2 * k2 + v * (10.0 * k2 + 15.0 * v)), 1.0);
}

// Returns the mean Fresnel reflectance of the facets visible from wo, the fraction of light that does not reach the diffuse base. The
// cosine is approximated by a normal variable, with mean and variance to second order about the mean visible facet, along the slope in the
// viewer's direction. Schlick's fifth power is averaged over this variable; the slope across this direction only lengthens N. S must be
// usable (clamp_covariance). crates/leadr-reflectance/src/visible/fresnel.rs has the derivation.
vec3 visible_fresnel(const vec3 wo, const vec2 m, const vec3 S, const vec3 f0) {
    vec2 across = vec2(S.x * wo.x + S.z * wo.y, S.z * wo.x + S.y * wo.y);
    float b2 = max(dot(across, wo.xy), 0.0);
    float per_b = inversesqrt(max(b2, 1e-24));
    float b = b2 * per_b;
    float a = tilted_area(wo, m, b);
    float t = min(a * per_b, 1e6);
    float lean = clamped_line(t).lean;
    float variance = clamp(2.0 - lean * (t + lean), 0.02, 1.0);
    vec2 axis = across * per_b;
    float rest = max(S.x + S.y - dot(axis, axis), 0.0);
    float mean = mean_schlick_weight(a + b * lean, b, axis, m - axis * lean, rest, variance);
    return f0 + (grazing_reflectance(f0) - f0) * mean;
}

#endif
