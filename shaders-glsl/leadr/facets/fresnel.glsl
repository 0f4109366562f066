#ifndef LEADR_FRESNEL_GLSL
#define LEADR_FRESNEL_GLSL

// Returns Schlick's weight, from 0 to 1: how far the reflectance has risen from its value at normal incidence to its value at grazing
// incidence.
float schlick_weight(const float cosine) {
    float k = clamp(1.0 - cosine, 0.0, 1.0);
    float k2 = k * k;
    return k2 * k2 * k;
}

// Returns the reflectance at grazing incidence, which is 1 for every real surface. No material has f0 below 2 %, so a smaller value means
// that only a fraction of the surface reflects (Lagarde & de Rousiers 2014). A value of 0 means diffuse facets without specular reflection.
vec3 grazing_reflectance(const vec3 f0) {
    return vec3(min(50.0 * max(f0.x, max(f0.y, f0.z)), 1.0));
}

// Returns Schlick's Fresnel term. f0 is the reflectance at normal incidence, and cosine is wi.wh.
vec3 fresnel_schlick(const vec3 f0, const float cosine) {
    return f0 + (grazing_reflectance(f0) - f0) * schlick_weight(cosine);
}

// Returns the weight of the F82 tint, cos (1 - cos)^6. The maximum of the weight is 0.057, at a cosine of 1/7.
float edge_tint_weight(const float cosine) {
    float c = clamp(cosine, 0.0, 1.0);
    float k = (1.0 - c) * (1.0 - c) * (1.0 - c);
    return c * k * k;
}

// Returns Schlick's term minus the F82 tint. The tint describes conductors whose reflectance falls before it rises (Lazanyi and
// Szirmay-Kalos 2005; Hoffman 2019).
vec3 fresnel_edge_tint(const vec3 f0, const vec3 edge_tint, const float cosine) {
    return fresnel_schlick(f0, cosine) - edge_tint * edge_tint_weight(cosine);
}

// Returns the unpolarised reflectance of a smooth dielectric, which is 1 at total reflection (Fresnel; Walter et al. 2007, eq. 22). eta > 0
// is the refractive index inside divided by the index outside.
float fresnel_dielectric(const float cosine, const float eta) {
    float c = clamp(abs(cosine), 0.0, 1.0);
    float g2 = eta * eta - 1.0 + c * c;
    if (g2 <= 0.0) return 1.0;
    float g = sqrt(g2);
    float s = (g - c) / max(g + c, 1e-12);
    float p = (c * (g + c) - 1.0) / max(c * (g - c) + 1.0, 1e-12);
    return min(0.5 * s * s * (1.0 + p * p), 1.0);
}

// Returns (difference^2 + b^2) / (sum^2 + b^2) per channel, or 1 for 0/0.
vec3 fresnel_ratio(const vec3 difference, const vec3 sum, const vec3 b) {
    return (difference * difference + b * b + 1e-30) / (sum * sum + b * b + 1e-30);
}

// Returns the unpolarised reflectance of a smooth conductor with complex index eta + i k per channel. eta and k must be >= 0, and are
// clamped below 1e4. Quotients of sums of squares replace the amplitude formulas, so that nothing cancels
// (crates/leadr-reflectance/src/facets/fresnel.rs).
vec3 fresnel_conductor(const float cosine, vec3 eta, vec3 k) {
    float c = min(abs(cosine), 1.0);
    float s2 = (1.0 - c) * (1.0 + c);
    eta = clamp(eta, 0.0, 1e4);
    k = clamp(k, 0.0, 1e4);
    // The root is a + i b = sqrt((eta + i k)^2 - s2). The larger of a and b is computed first.
    vec3 re = (eta - k) * (eta + k) - s2;
    vec3 im = eta * k;
    vec3 larger = sqrt(0.5 * (sqrt(re * re + 4.0 * im * im) + abs(re)));
    vec3 smaller = im / max(larger, 1e-15);
    vec3 a = mix(smaller, larger, greaterThanEqual(re, vec3(0.0)));
    vec3 b = mix(larger, smaller, greaterThanEqual(re, vec3(0.0)));
    vec3 s_polarised = fresnel_ratio(a - c, a + c, b);
    return min(0.5 * s_polarised * (1.0 + fresnel_ratio(a * c - s2, a * c + s2, b * c)), 1.0);
}

#endif
