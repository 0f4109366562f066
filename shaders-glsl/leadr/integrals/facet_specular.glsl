#ifndef LEADR_FACET_SPECULAR_GLSL
#define LEADR_FACET_SPECULAR_GLSL

#include "../facets/fresnel.glsl"
#include "../masking/correlated.glsl"
#include "../slopes/grid.glsl"

// Computes the specular response to a light, for a relief whose facets have a Beckmann base in their own frame. Four sample facets
// represent all facets that reflect the light. crates/leadr-reflectance/src/integrals/facet_specular.rs gives the derivation. For each
// light
//     FacetSpecular f = facet_specular(wo, wi, alpha, variance of the light's directions);
//     radiance += irradiance * facet_specular_light(shadowing, o, i, f, m, cholesky, f0);
// where o, i and cholesky belong to the relief without its base.

const float LEADR_LEAST_HALFWAY_Z = 0.1;
const float LEADR_LEAST_HALF_COSINE2 = 1e-3;
const float LEADR_LEAST_BASE_VARIANCE = 1e-8;
const float LEADR_LEAST_FACET_COSINE = 1e-3;
const float LEADR_LEAST_LINEAR_COSINE = 0.05;
const float LEADR_LEAST_MAPPED_COSINE = 0.02;
const float LEADR_TOWARDS_PLANE = 0.7;
const float LEADR_LEAST_Q = 0.02;
const float LEADR_MOST_DEVIATIONS = 50.0;

// A light and a viewer, their half vector, and the width of the specular lobe about the half vector.
struct FacetSpecular {
    vec3 wo;
    vec3 wi;
    vec3 wh;
    vec3 along;     // the axis orthogonal to wh in the plane of incidence
    vec3 beside;
    vec2 deviation; // standard deviations of the base's slopes along both axes, including the size of the light
    float base;     // standard deviation of the base's slopes, without the size of the light
};

FacetSpecular facet_specular(const vec3 wo, const vec3 wi, const float alpha, const float variance) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    vec3 d = wi - wo;
    float apart = dot(d, d);
    // If wi and wo coincide, any axis orthogonal to wh is correct.
    vec3 along = apart > 1e-8 ? d * inversesqrt(apart) : normalize(vec3(wh.z, 1e-6, -wh.x));
    float cosine = dot(wo, wh);
    vec2 size = 0.25 * variance / vec2(1.0, max(cosine * cosine, LEADR_LEAST_HALF_COSINE2));
    vec2 deviation = sqrt(size + max(0.5 * alpha * alpha, LEADR_LEAST_BASE_VARIANCE));
    return FacetSpecular(wo, wi, wh, along, cross(wh, along), deviation, 0.70710678 * alpha);
}

// Returns the fraction of a facet's specular response that remains after masking and shadowing, or 0 if the facet faces away. co and ci are
// the cosines of wo and wi with the facet's normal. between is the cosine of wo and wi, and deviation is the standard deviation of the
// base's slopes. On a normal map, only the base occludes: the viewer sees all of a facet that faces him, and an edge-on facet fades out.
float facet_visibility(const int shadowing, const float co, const float ci, const float between, const float deviation) {
    bool mapped = shadowing == LEADR_SHADOWING_NORMAL_MAP;
    float so = sqrt(max(1.0 - co * co, 0.0)), si = sqrt(max(1.0 - ci * ci, 0.0));
    // The axes are orthogonal to the facet's normal. The first axis points toward the viewer.
    float toward = clamp((between - co * ci) / max(so, 1e-6), -si, si);
    float aside = sqrt(max(si * si - toward * toward, 0.0));
    float bo = so * deviation, bi = si * deviation;
    DirectionArea o = DirectionArea(vec2(bo, 0.0), bo, co, max(co, 0.0) + rough_area(co, bo));
    DirectionArea i = DirectionArea(vec2(toward, aside) * deviation, bi, ci, max(ci, 0.0) + rough_area(ci, bi));
    float seen = mapped ? min(co / max(deviation, LEADR_LEAST_MAPPED_COSINE), 1.0) : co;
    return max(seen, 0.0) * masking_shadowing_factor(mapped ? LEADR_SHADOWING_CORRELATED : shadowing, o, i);
}

// A Gaussian over the facets that reflect a light, in standard coordinates of the relief's slopes.
struct ReflectingFacets {
    vec2 middle;
    vec3 inverse; // inverse of the covariance, as xx, yy, xy
    float determinant;
};

// Linearises the slopes u of the half vector relative to the facets. The expansion is about the facet of slope `about`.
ReflectingFacets reflecting_facets(const FacetSpecular f, const vec2 about, const vec2 m, const vec3 cholesky) {
    vec3 n = vec3(-about, 1.0);
    float per = 1.0 / max(dot(n, f.wh), LEADR_LEAST_LINEAR_COSINE * length(n));
    // The values at the mean slope and their gradients are in units of the base's standard deviation.
    vec2 u = vec2(dot(n, f.along), dot(n, f.beside)) * per;
    vec3 along = (u.x * f.wh - f.along) * (per / f.deviation.x);
    vec3 beside = (u.y * f.wh - f.beside) * (per / f.deviation.y);
    vec2 away = m - about;
    vec2 at = u / f.deviation + vec2(dot(along.xy, away), dot(beside.xy, away));
    vec2 a = whitened_direction(along, cholesky), b = whitened_direction(beside, cholesky);
    // The precision of the relief's slopes and the precisions along both axes add.
    vec3 inverse = vec3(1.0 + a * a + b * b, a.x * a.y + b.x * b.y);
    float across = a.x * b.y - a.y * b.x;
    float determinant = 1.0 + dot(a, a) + dot(b, b) + across * across;
    vec2 pull = -(a * at.x + b * at.y);
    vec2 middle = vec2(inverse.y * pull.x - inverse.z * pull.y, inverse.x * pull.y - inverse.z * pull.x) / determinant;
    return ReflectingFacets(clamp(middle, -LEADR_MOST_DEVIATIONS, LEADR_MOST_DEVIATIONS), inverse, determinant);
}

// Returns the density of half vectors over the facets that are visible to viewer and light, per area of the macrosurface.
float facet_specular_density(const FacetSpecular f, vec2 m, const vec3 cholesky, const int shadowing) {
    m = clamp(m, -LEADR_MAX_SLOPE, LEADR_MAX_SLOPE);
    vec3 halfway = normalize(vec3(-m, 1.0)) + f.wh;
    vec2 start = reflecting_facets(f, halfway.xy / -max(halfway.z, LEADR_LEAST_HALFWAY_Z), m, cholesky).middle;
    vec2 likely = slope_at(start, m, cholesky);
    ReflectingFacets found = reflecting_facets(f, likely, m, cholesky);
    vec2 lean = whitened_direction(vec3(LEADR_TOWARDS_PLANE / (1.0 + dot(likely, likely)) * likely, 0.0), cholesky);

    // The coordinates p lie between slopes and the plane that touches the sphere of normals at the most likely facet. The four nodes lie
    // sqrt(2) standard deviations from the centre.
    vec2 reach = inversesqrt(found.inverse.y * vec2(0.5 * found.determinant, 0.5));
    vec2 first = vec2(found.inverse.y, -found.inverse.z) * reach.x, second = vec2(0.0, reach.y);
    float between = dot(f.wo, f.wi), sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        vec2 p = found.middle - start + ((k & 2) == 0 ? first : second) * ((k & 1) == 0 ? 1.0 : -1.0);
        float q = 1.0 - dot(lean, p);
        vec2 z = start + p / max(q, LEADR_LEAST_Q);
        vec3 facet = vec3(-slope_at(z, m, cholesky), 1.0);
        float per_length = inversesqrt(dot(facet, facet));
        vec3 normal = facet * per_length;
        float cosine = dot(normal, f.wh);
        if (cosine > LEADR_LEAST_FACET_COSINE && q > LEADR_LEAST_Q) {
            vec2 t = vec2(dot(normal, f.along), dot(normal, f.beside)) / (cosine * f.deviation);
            float seen = facet_visibility(shadowing, dot(normal, f.wo), dot(normal, f.wi), between, f.base);
            // On a normal map, facets count by their area on the macrosurface.
            float area = shadowing == LEADR_SHADOWING_NORMAL_MAP ? 1.0 : 1.0 / per_length;
            float scaled = cosine * q;
            sum += exp(-0.5 * (dot(z, z) + dot(t, t))) * (seen * area / (cosine * scaled * scaled * scaled));
        }
    }
    // The factor is e / 8 pi, because the density at nodes sqrt(2) deviations from the centre is exp(-1) of the central density.
    return 0.1081569970 * sum / (sqrt(found.determinant) * f.deviation.x * f.deviation.y);
}

// Returns the radiance towards the viewer, per unit of the light's irradiance on a plane that faces it. The facets of the base shadow each
// other by the model `of_base`.
vec3 facet_specular_light(const int shadowing, const int of_base, const DirectionArea o, const DirectionArea i, const FacetSpecular f, const vec2 m,
                          const vec3 cholesky, const vec3 f0) {
    float d = facet_specular_density(f, m, cholesky, of_base);
    return fresnel_schlick(f0, dot(f.wi, f.wh)) * (0.25 * d * masking_shadowing_factor(shadowing, o, i));
}

// Returns the same with one model for all facets.
vec3 facet_specular_light(const int shadowing, const DirectionArea o, const DirectionArea i, const FacetSpecular f, const vec2 m,
                          const vec3 cholesky, const vec3 f0) {
    return facet_specular_light(shadowing, shadowing, o, i, f, m, cholesky, f0);
}

#endif
