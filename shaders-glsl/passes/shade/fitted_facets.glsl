// Measured facets for samples of the reference. The tables of the facets are used directly, not the fitted lobes.
#ifndef LEADR_SHADE_FITTED_FACETS
#define LEADR_SHADE_FITTED_FACETS
#include "draws.glsl"
#include "surface.glsl"

// The fraction of the directions that are drawn from the hemisphere. Such directions sample slopes that the lobes hardly cover.
const float DEFENSIVE = 0.125;

// A measured facet and its view direction, in the frame of its table.
struct FittedFacet {
    uint fit;
    float stretch;
    mat3 rotation;  // rotation from the frame of the surface to the frame of the table
    vec3 wo;
    float area; // visible area of the facet's lobes along wo
};

// Returns the normal of a facet visible from wo, with mean slope m and covariance S. On a normal map, the facet need not be visible. Maps
// store the slopes of a texel as moments, which can widen a lobe but not a table. Anisotropic fits follow the axes of S.
vec3 fitted_normal(const uint fit, const vec3 wo, const vec2 m, const vec3 S, const bool mapped, const vec2 u) {
    if (!fitted_is_round(fit) || S.x + S.y <= 2.0 * LEADR_MIN_VARIANCE) {
        return normal_of_slope(m);
    }
    if (!mapped) {
        return beckmann_sample_visible(wo, u, m, S);
    }
    return normal_of_slope(slope_at(vec2(normal_quantile(u.x), normal_quantile(u.y)), m, slope_cholesky(S)));
}

// Returns the measured facet. normal is the normal of the facet, and widest is the covariance that gives the direction of anisotropy.
FittedFacet fitted_facet(uint fit, const float alpha, vec3 wo, const vec3 normal, const vec3 widest) {
    FittedFacet f;
    f.fit = fit;
    f.stretch = fit_stretch(fit, alpha);
    Frame frame = frame_about(normal);
    f.rotation = transpose(mat3(frame.x, frame.y, frame.z));
    if (!fitted_is_round(fit) && abs(widest.x - widest.y) + abs(widest.z) > 1e-7) {
        float angle = 0.5 * atan(2.0 * widest.z, widest.x - widest.y) - fitted_direction(fit);
        float c = cos(angle), s = sin(angle);
        f.rotation = mat3(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0) * f.rotation;
    }
    f.wo = f.rotation * wo;
    f.area = fitted_lobes_area(fit, f.wo, f.stretch);
    return f;
}

// Returns the radiance towards the viewer per unit of irradiance on a plane that faces wi.
vec3 fitted_reflected(const FittedFacet f, vec3 wi) {
    wi = f.rotation * wi;
    if (f.wo.z <= 0.0 || wi.z <= 0.0) {
        return vec3(0.0);
    }
    return fitted_fresnel(f.fit, 0.5 * length(f.wo + wi)) * fitted_specular(f.fit, f.wo, wi, f.stretch);
}

// Returns the density of a drawn direction per solid angle.
float fitted_density(const FittedFacet f, vec3 wi) {
    wi = f.rotation * wi;
    vec3 h = f.wo + wi;
    vec3 wn = h * inversesqrt(max(dot(h, h), 1e-20));
    return (1.0 - DEFENSIVE) * fitted_lobes_density(f.fit, f.wo, wn, f.area, f.stretch) + DEFENSIVE / LEADR_PI * max(wi.z, 0.0);
}

// Draws a direction from the facet's specular term.
vec3 fitted_direction_drawn(const FittedFacet f, const vec2 u) {
    if (u.x < DEFENSIVE) {
        return drawn_cosine(vec2(u.x / DEFENSIVE, u.y)) * f.rotation;
    }
    // One random number selects the lobe and the point on the lobe. The number has enough digits for lobe and point.
    float choice = (u.x - DEFENSIVE) / (1.0 - DEFENSIVE) * 64.0;
    vec3 wn = fitted_lobes_normal(f.fit, f.wo, (floor(choice) + 0.5) / 64.0, vec2(fract(choice), u.y), f.area, f.stretch);
    vec3 wi = 2.0 * max(dot(f.wo, wn), 0.0) * wn - f.wo;
    return wi * f.rotation;
}

#endif
