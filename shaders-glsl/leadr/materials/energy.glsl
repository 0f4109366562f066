#ifndef LEADR_ENERGY_GLSL
#define LEADR_ENERGY_GLSL

#include "../constants.glsl"
#include "../facets/fresnel.glsl"

// Computes the total reflectance of specular facets, and restores the light of all bounces after the first, which single scattering loses,
// by one of two methods (Kulla and Conty 2017; Turquin 2019; crates/leadr-reflectance/src/materials/energy.rs). The includer defines the
// albedo, a table of 33 columns and 48 rows:
//     uniform sampler2D energy;
//     #define LEADR_ENERGY_TEXEL(x, y) texelFetch(energy, ivec2(x, y), 0).xy
// EnergyTable::texels fills the table with (1 - ideal, grazing) at cos = (x / 31)^2 and alpha = (y / 47)^4. The column x = 32 has the
// averages. An albedo is vec2(ideal, grazing): ideal is the albedo for F = 1, and grazing is the albedo for F = (1 - cos)^5.

#ifndef LEADR_ENERGY_TEXEL
#error define LEADR_ENERGY_TEXEL(x, y) before this file: texel of the table of energies
#endif

// Returns the table's value at a roughness, interpolated between column x and the next column.
vec2 energy_between(const float alpha, const int x, const float t) {
    float y = sqrt(sqrt(clamp(alpha, 0.0, 1.0))) * 47.0;
    int row = min(int(y), 46);
    int next = min(x + 1, 32);
    vec2 low = mix(LEADR_ENERGY_TEXEL(x, row), LEADR_ENERGY_TEXEL(next, row), t);
    vec2 high = mix(LEADR_ENERGY_TEXEL(x, row + 1), LEADR_ENERGY_TEXEL(next, row + 1), t);
    vec2 texel = mix(low, high, y - float(row));
    return vec2(1.0 - texel.x, texel.y);
}

// Returns the albedo towards a viewer, as vec2(ideal, grazing).
vec2 energy_albedo(const float alpha, const float cosine) {
    float x = sqrt(clamp(cosine, 0.0, 1.0)) * 31.0;
    int column = min(int(x), 30);
    float t = x - float(column);
    // Near grazing incidence, albedos are linear in the cosine, not in the square root of the cosine.
    return energy_between(alpha, column, column == 0 ? t * t : t);
}

// Returns the mean albedo over the cosine-weighted hemisphere.
vec2 energy_average(const float alpha) {
    return energy_between(alpha, 32, 0.0);
}

// Returns the albedo for fresnel_schlick with this f0.
vec3 split_albedo(const vec3 f0, const vec2 albedo) {
    return f0 * (albedo.x - albedo.y) + grazing_reflectance(f0) * albedo.y;
}

// Returns the mean of Schlick's Fresnel term over the cosine-weighted hemisphere.
vec3 average_fresnel(const vec3 f0) {
    return f0 + (grazing_reflectance(f0) - f0) / 21.0;
}

// Returns the fraction of the lost light that leaves the surface after all further bounces, F^2 E / (1 - F (1 - E)), for the mean f of any
// Fresnel term over the cosine-weighted hemisphere.
vec3 bounced_color(const vec3 f, const float average_ideal) {
    return f * f * average_ideal / max(1.0 - f * (1.0 - average_ideal), vec3(1e-6));
}

vec3 compensation_color(const vec3 f0, const float average_ideal) {
    return bounced_color(average_fresnel(f0), average_ideal);
}

// Returns the BRDF of the light that ideal facets (F = 1) reflect more than once. Multiply it by compensation_color.
float compensation_lobe(const float ideal_o, const float ideal_i, const float average_ideal) {
    return (1.0 - ideal_o) * (1.0 - ideal_i) / (LEADR_PI * max(1.0 - average_ideal, 1e-6));
}

// Returns the factor on the single-scattering lobe that restores the albedo of all bounces for F0 = 1. This factor is cheaper than
// compensation_lobe, but not reciprocal.
vec3 compensation_scale(const vec3 f0, const float ideal_o) {
    float e = max(ideal_o, 1e-3);
    return 1.0 + f0 * ((1.0 - e) / e);
}

// Returns the total specular reflection towards the viewer.
vec3 specular_albedo(const vec3 f0, const vec2 albedo, const float average_ideal) {
    return split_albedo(f0, albedo) + (1.0 - albedo.x) * compensation_color(f0, average_ideal);
}

// Returns the light that enters the diffuse base below the facets. With energy_average as the albedo, the result is the mean over the
// hemisphere.
vec3 entered(const vec3 f0, const vec2 albedo, const float average_ideal) {
    return max(1.0 - specular_albedo(f0, albedo, average_ideal), 0.0);
}

#endif
