#ifndef LEADR_DIFFUSE_MODELS_GLSL
#define LEADR_DIFFUSE_MODELS_GLSL

#include "../facets/gloss.glsl"
#include "multiscattering.glsl"

// Reflection of a rough diffuse base, relative to Lambert's law. Functions return pi f_r / albedo; those named _albedo return the mean of
// this value over the cosine-weighted hemisphere of the other direction. Directions are in the tangent frame of a facet of the relief.
// crates/leadr-reflectance/src/materials/diffuse_models.rs has the sources and the tests.

const int LEADR_DIFFUSE_LAMBERT = 0;
const int LEADR_DIFFUSE_OREN_NAYAR = 1;
const int LEADR_DIFFUSE_DISNEY = 2;
const int LEADR_DIFFUSE_CALL_OF_DUTY = 3;
const int LEADR_DIFFUSE_MULTISCATTERING = 4; // multiscattering_diffuse, which needs the tables of the coat
const int LEADR_DIFFUSE_BLEND = 5; // (1 - albedo) of the specular term beside Lambert's law (thesis eq. 5.4)
const int LEADR_DIFFUSE_CONSERVING = 6; // 1 - split_albedo toward the light (Chan 2018, listing 5)

// The coefficients A (per colour) and B of Oren and Nayar's model (Fujii 2012).
struct OrenNayar {
    vec3 a;
    float b;
};

OrenNayar oren_nayar_terms(const float alpha, const vec3 albedo) {
    float sigma = atan(clamp(alpha, 0.0, 1.0));
    float square = sigma * sigma;
    return OrenNayar(1.0 - 0.5 * square / (square + 0.33) + albedo * (0.17 * square / (square + 0.13)), 0.45 * square / (square + 0.09));
}

vec3 oren_nayar(const vec3 wo, const vec3 wi, const float alpha, const vec3 albedo) {
    OrenNayar terms = oren_nayar_terms(alpha, albedo);
    float s = dot(wo.xy, wi.xy);
    return terms.a + terms.b * s / (s > 0.0 ? max(max(wo.z, wi.z), 1e-6) : 1.0);
}

vec3 oren_nayar_albedo(const float cosine, const float alpha, const vec3 albedo) {
    OrenNayar terms = oren_nayar_terms(alpha, albedo);
    float c = clamp(cosine, 1e-4, 1.0);
    float s = sqrt((1.0 - c) * (1.0 + c));
    // atan is precise where acos is not.
    float g = s * (atan(s, c) - s * c) + 2.0 / 3.0 * (s / c * (1.0 - s * s * s) - s);
    return terms.a + terms.b * g / LEADR_PI;
}

// Returns Burley's model (2012), whose roughness is sqrt(alpha). The model contains its own loss to the coat.
float disney_diffuse(const vec3 wo, const vec3 wi, const float alpha) {
    float grazing = sqrt(clamp(alpha, 0.0, 1.0)) * (1.0 + dot(wo, wi)) - 0.5;
    return (1.0 + grazing * schlick_weight(wo.z)) * (1.0 + grazing * schlick_weight(wi.z));
}

float disney_albedo(const float cosine, const float alpha) {
    float c = clamp(cosine, 0.0, 1.0), r = sqrt(clamp(alpha, 0.0, 1.0));
    float p = r - 0.5, w = schlick_weight(c), q = r * c;
    float both = p * p / 21.0 + p * q / 42.0 + q * q / 252.0 + r * r * (1.0 - c * c) * 11.0 / 504.0;
    return 1.0 + p / 21.0 + q / 84.0 + w * (p + 2.0 / 3.0 * q + both);
}

// Returns the directional albedo of chan_diffuse, a fit with errors of up to 0.004.
float chan_albedo(const float cosine, const float gloss) {
    float c = clamp(cosine, 0.0, 1.0), g = clamp(gloss, 0.0, 1.0);
    float rough = 0.704501 + c * (0.193849 + c * (0.01657 - 0.003074 * c));
    float smoothed = (1.0 - 0.75 / 21.0) * (1.0 - 0.75 * schlick_weight(c));
    float rate = max(73.2 * g - 21.2, 8.9) - 8.9;
    float narrow = 10.9178 / (rate + 10.9178);
    float bump = 0.0183685 * narrow * narrow * narrow * narrow * pow(1.0 + 2.13598 * c, -1.69872 - 0.319595 * rate);
    return rough + (smoothed - rough) * clamp(2.2 * g - 0.5, 0.0, 1.0) + (34.5 * g * g - 59.0 * g + 24.5) * bump;
}

// Returns the value of a model, or 1 for the models without a value of their own.
vec3 diffuse_value(const int model, const vec3 wo, const vec3 wi, const float alpha, const vec3 albedo) {
    if (model == LEADR_DIFFUSE_OREN_NAYAR) return oren_nayar(wo, wi, alpha, albedo);
    if (model == LEADR_DIFFUSE_DISNEY) return vec3(disney_diffuse(wo, wi, alpha));
    if (model == LEADR_DIFFUSE_CALL_OF_DUTY) {
        vec3 h = wo + wi;
        h *= inversesqrt(max(dot(h, h), 1e-20));
        return vec3(max(chan_diffuse(wi.z, wo.z, h.z, dot(wi, h), alpha_gloss(alpha, LEADR_GLOSS_WWII)), 0.0));
    }
    return vec3(1.0);
}

// Returns the directional albedo of diffuse_value.
vec3 diffuse_model_albedo(const int model, const float cosine, const float alpha, const vec3 albedo) {
    if (model == LEADR_DIFFUSE_OREN_NAYAR) return oren_nayar_albedo(cosine, alpha, albedo);
    if (model == LEADR_DIFFUSE_DISNEY) return vec3(disney_albedo(cosine, alpha));
    if (model == LEADR_DIFFUSE_CALL_OF_DUTY) return vec3(chan_albedo(cosine, alpha_gloss(alpha, LEADR_GLOSS_WWII)));
    return vec3(1.0);
}

#endif
