#ifndef LEADR_FRESNEL_GLSL
#define LEADR_FRESNEL_GLSL

// Schlick's Fresnel term. f0: reflectance at normal incidence; cosine: wi.wh.
vec3 fresnel_schlick(vec3 f0, float cosine) {
    float k = clamp(1.0 - cosine, 0.0, 1.0);
    float k2 = k * k;
    return f0 + (1.0 - f0) * (k2 * k2 * k);
}

// Unpolarised reflectance of a smooth dielectric; eta: index inside over index outside, > 0; 1 at total reflection
// (Fresnel; Walter et al. 2007, eq. 22).
float fresnel_dielectric(float cosine, float eta) {
    float c = clamp(abs(cosine), 0.0, 1.0);
    float g2 = eta * eta - 1.0 + c * c;
    if (g2 <= 0.0) return 1.0;
    float g = sqrt(g2);
    float s = (g - c) / max(g + c, 1e-12);
    float p = (c * (g + c) - 1.0) / max(c * (g - c) + 1.0, 1e-12);
    return min(0.5 * s * s * (1.0 + p * p), 1.0);
}

#endif
