#ifndef LEADR_MULTISCATTERING_GLSL
#define LEADR_MULTISCATTERING_GLSL

#include "../constants.glsl"
#include "../facets/fresnel.glsl"

// Diffuse reflection of rough surfaces under a specular coat, including light that bounces between facets (Chan 2018, section 5, and a fit
// of this project). crates/leadr-reflectance/src/materials/multiscattering.rs has the formulas and proves the albedo.

// Returns the BRDF of a white diffuse facet below a coat (eq. 62). The albedo of this facet is 1 - F.
float facet_diffuse(const float f0, const float cosine_o, const float cosine_i) {
    return 21.0 / (20.0 * LEADR_PI) * (1.0 - f0) * (1.0 - schlick_weight(cosine_o)) * (1.0 - schlick_weight(cosine_i));
}

// Evaluates the hand fit that the paper published (eq. 64-69 and listing 1), without albedo / pi. The albedo of this fit exceeds 1.
float chan_diffuse(float n_l, float n_v, float n_h, float l_h, const float gloss) {
    n_l = clamp(n_l, 0.0, 1.0);
    n_v = clamp(n_v, 0.0, 1.0);
    n_h = clamp(n_h, 0.0, 1.0);
    l_h = clamp(l_h, 0.0, 1.0);
    float g = clamp(gloss, 0.0, 1.0);
    float rough = l_h + schlick_weight(l_h);
    float smoothed = (1.0 - 0.75 * schlick_weight(n_l)) * (1.0 - 0.75 * schlick_weight(n_v));
    float t = clamp(2.2 * g - 0.5, 0.0, 1.0);
    float bump = (34.5 * g * g - 59.0 * g + 24.5) * l_h * exp2(-max(73.2 * g - 21.2, 8.9) * sqrt(n_h));
    return rough + (smoothed - rough) * t + bump;
}

// The parameters of the light that bounces between facets of one roughness.
struct FacetBounces {
    float grazing; // weight of the first bounce at grazing angles
    float again;   // probability that light leaving a facet hits another facet
    float lean;    // bias of the remaining first bounce towards the light
    float lost;    // fraction of the light lost between facets
};

float bounce_value(const float alpha, const vec3 k) {
    float a = clamp(alpha, 0.0, 1.0);
    return k.x * a * a / max(a * a + k.y * a + k.z, 1e-9);
}

// Returns the parameters of facets whose coat reflects specularly, so that no light is lost.
FacetBounces facet_bounces(const float alpha) {
    return FacetBounces(bounce_value(alpha, vec3(0.39284, 0.11088, 0.01835)),
                        clamp(bounce_value(alpha, vec3(0.92213, 0.76687, 0.46287)), 0.0, 0.9),
                        clamp(bounce_value(alpha, vec3(0.36175, -0.7515, 0.48674)), -1.0, 1.0),
                        clamp(bounce_value(alpha, vec3(0.0, 0.0, 1.0)), 0.0, 1.0));
}

// Returns the parameters of facets whose coat absorbs the light it reflects, as in the paper's simulation.
FacetBounces facet_bounces_lossy(const float alpha) {
    return FacetBounces(bounce_value(alpha, vec3(0.38738, 0.12849, 0.02321)),
                        clamp(bounce_value(alpha, vec3(0.84374, 0.74115, 0.45752)), 0.0, 0.9),
                        clamp(bounce_value(alpha, vec3(0.49619, -0.73675, 0.60793)), -1.0, 1.0),
                        clamp(bounce_value(alpha, vec3(0.38913, 1.77282, 0.13691)), 0.0, 1.0));
}

// Returns 2 (1 - c ln(1 + 1/c)), the albedo of 1 / (c_o + c_i) over 1/pi.
float grazing_albedo(const float cosine) {
    float c = clamp(cosine, 1e-12, 1.0);
    return 2.0 * (1.0 - c * log((1.0 + c) / c));
}

// Returns the albedo of the first bounce, relative to the albedo of the facets and to the light that enters.
vec3 first_albedo(const FacetBounces bounces, const vec3 albedo) {
    return (1.0 - bounces.lost) * (1.0 - bounces.again) / (1.0 - albedo * bounces.again);
}

// Returns the albedo of facets whose surface has this albedo for the light that enters it, 0..1.
vec3 facet_albedo(const FacetBounces bounces, const vec3 albedo) {
    float kept = (1.0 - bounces.lost) * (1.0 - bounces.again);
    return min(albedo / max(kept + albedo * bounces.again, 1e-6), 1.0);
}

// Returns the BRDF per steradian, which is 0 for directions on or below the horizon. entered_o and entered_i are the fractions of light
// that enter along the directions of the viewer and of the light, and entered_average is the mean over all directions (`entered` in
// energy.glsl).
vec3 multiscattering_diffuse(const vec3 wo, const vec3 wi, const FacetBounces bounces, const vec3 f0, const vec3 albedo,
                             const vec3 entered_o, const vec3 entered_i,
                             const vec3 entered_average) {
    if (wo.z <= 0.0 || wi.z <= 0.0) return vec3(0.0);
    float c_o = min(wo.z, 1.0), c_i = min(wi.z, 1.0);
    float d = wo.x * wi.x + wo.y * wi.y;
    float sines = (1.0 - c_o * c_o) * (1.0 - c_i * c_i);
    float phase = max(1.0 + 11.0 / 9.0 * d + 2.0 / 9.0 * (2.0 * d * d - sines), 0.0);
    // kappa is smaller for dark facets, because they have only the first bounce.
    vec3 kappa = bounces.grazing * (1.0 - f0) * (1.0 - 0.7 * bounces.again * (1.0 - albedo));
    vec3 white = first_albedo(bounces, albedo);
    vec3 r_o = max(entered_o * white - kappa * grazing_albedo(c_o), 0.0);
    vec3 r_i = max(entered_i * white - kappa * grazing_albedo(c_i), 0.0);
    // The constant is 8/3 (1 - ln 2), the mean of grazing_albedo.
    vec3 average = max(entered_average * white - kappa * 0.818274185, 1e-6);
    vec3 lean = 1.0 + (1.0 - albedo * bounces.again) * (bounces.lean * d);
    return albedo / LEADR_PI * (kappa * (phase / max(c_o + c_i, 1e-6)) + r_o * (r_i / average) * lean);
}

// Returns the directional albedo of multiscattering_diffuse. `entered` is the light that enters along this direction.
vec3 multiscattering_albedo(const FacetBounces bounces, const vec3 albedo, const vec3 enters) {
    return albedo * first_albedo(bounces, albedo) * enters;
}

#endif
