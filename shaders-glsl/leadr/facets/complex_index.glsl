#ifndef LEADR_COMPLEX_INDEX_GLSL
#define LEADR_COMPLEX_INDEX_GLSL

#include "fresnel.glsl"

// The exact Fresnel term of a material that is given by its reflectance at normal incidence and an F82 edge tint.
// crates/leadr-reflectance/src/facets/complex_index.rs has the derivation. Once per surface
//     ComplexIndex index = complex_index(f0, edge_tint);
// and for each facet
//     vec3 f = fresnel_exact(f0, index, cosine);

// A complex index of refraction eta + i k for each colour channel.
struct ComplexIndex {
    vec3 eta;
    vec3 k;
};

// The reflectances at normal incidence for which an index is computed. The absorption of other surfaces is that of the nearest, scaled.
const vec2 LEADR_INDEXED = vec2(0.01, 0.99);
// Dielectrics reflect at most the first value at normal incidence, and metals at least the second in one channel.
const vec2 LEADR_METAL_REFLECTANCE = vec2(0.2, 0.4);
// Between these reflectances of a channel, a metal becomes a dielectric.
const vec2 LEADR_DARK_CHANNEL = vec2(0.05, 0.2);
// The cosine at which the reflectance of a metal is matched, where the edge tint weighs most.
const float LEADR_EDGE_COSINE = 1.0 / 7.0;

// Returns the eta from `least` to `most` for which the approximation for large indices has the reflectance `edge` at LEADR_EDGE_COSINE.
vec3 eta_of_edge(const vec3 r, const vec3 edge, const vec3 least, const vec3 most) {
    const float c = LEADR_EDGE_COSINE;
    vec3 q = (1.0 + r) / (1.0 - r);
    vec3 a = q + c, b = q * (c * c) + c;
    vec3 d = c * (a + b) / max(1.0 - edge, vec3(1e-4));
    vec3 root = sqrt(max((a + b) * (a + b) - 4.0 * d, 0.0));
    // The smaller of the roots, without cancellation.
    vec3 y = 2.0 * (d - a * b) / (a - b + root);
    return clamp(0.5 * (1.0 - c * c) / max(y, vec3(1e-6)), least, most);
}

// Returns the k that gives the reflectance r at normal incidence together with eta.
vec3 extinction_of(const vec3 r, const vec3 eta) {
    return sqrt(max((r * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - r), 0.0));
}

// Returns the reflectance at normal incidence of the reflecting fraction of a surface, within LEADR_INDEXED.
vec3 indexed_reflectance(const vec3 f0) {
    return clamp(f0 / max(grazing_reflectance(f0), vec3(1e-6)), LEADR_INDEXED.x, LEADR_INDEXED.y);
}

// Returns the index of a surface with the reflectance f0 at normal incidence. The edge tint is that of fresnel_edge_tint.
ComplexIndex complex_index(const vec3 f0, const vec3 edge_tint) {
    vec2 range = LEADR_METAL_REFLECTANCE;
    float metallic = clamp((max(f0.x, max(f0.y, f0.z)) - range.x) / (range.y - range.x), 0.0, 1.0);
    vec3 r = indexed_reflectance(f0);
    vec3 root = sqrt(r);
    vec3 least = (1.0 - r) / (1.0 + r), most = (1.0 + root) / (1.0 - root);
    vec3 edge = r + (1.0 - r) * schlick_weight(LEADR_EDGE_COSINE) - edge_tint * edge_tint_weight(LEADR_EDGE_COSINE);
    if (metallic <= 0.0) {
        return ComplexIndex(most, vec3(0.0));
    }
    vec3 first = eta_of_edge(r, edge, least, most);
    vec3 reached = fresnel_conductor(LEADR_EDGE_COSINE, first, extinction_of(r, first));
    range = LEADR_DARK_CHANNEL;
    vec3 share = metallic * clamp((r - range.x) / (range.y - range.x), 0.0, 1.0);
    vec3 eta = most + share * (eta_of_edge(r, 2.0 * edge - reached, least, most) - most);
    return ComplexIndex(eta, extinction_of(r, eta));
}

// Returns the exact reflectance of a surface with the reflectance f0 at normal incidence and its complex_index.
vec3 fresnel_exact(const vec3 f0, const ComplexIndex index, const float cosine) {
    vec3 grazing = grazing_reflectance(f0);
    vec3 absorbed = 1.0 - fresnel_conductor(clamp(cosine, 0.0, 1.0), index.eta, index.k);
    return grazing - absorbed * (grazing - f0) / (1.0 - indexed_reflectance(f0));
}

// Returns the exact reflectance minus Schlick's. It vanishes at normal and at grazing incidence.
vec3 fresnel_deviation(const vec3 f0, const ComplexIndex index, const float cosine) {
    return fresnel_exact(f0, index, cosine) - fresnel_schlick(f0, cosine);
}

// Returns the mean of fresnel_deviation over the cosine-weighted hemisphere.
vec3 average_deviation(const vec3 f0, const ComplexIndex index) {
    const vec4 cosines = vec4(0.0694318, 0.3300095, 0.6699905, 0.9305682), weights = vec4(0.0241522, 0.2152141, 0.4369311, 0.3237026);
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        mean += weights[i] * fresnel_deviation(f0, index, cosines[i]);
    }
    return mean;
}

#endif
