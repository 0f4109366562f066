// Measured facets themselves, not their lobes: what samples of the reference see.
#ifndef LEADR_SHADE_FITTED_FACETS
#define LEADR_SHADE_FITTED_FACETS
#include "draws.glsl"
#include "surface.glsl"

// Share of the directions that are drawn from the hemisphere, for slopes that lobes have hardly any of.
const float DEFENSIVE = 0.125;

// A measured facet from where it is seen, in the frame of its table.
struct FittedFacet {
    uint fit;
    float stretch;
    mat3 turn;  // from the surface's frame to the table's
    vec3 wo;
    float area; // that wo sees of its lobes
};

// The normal of a facet among those that wo sees of slopes m with covariance S, or, of a mapped normal, among all of them. Maps know a
// texel's slopes by these alone, where a table, unlike a lobe, cannot be widened by them. Fits that are rougher along one direction are
// brushed along that of S.
vec3 fitted_normal(const uint fit, const vec3 wo, const vec2 m, const vec3 S, const bool mapped, const vec2 u) {
    if (!fitted_is_round(fit) || S.x + S.y <= 2.0 * LEADR_MIN_VARIANCE) {
        return normal_of_slope(m);
    }
    if (!mapped) {
        return beckmann_sample_visible(wo, u, m, S);
    }
    return normal_of_slope(slope_at(vec2(normal_quantile(u.x), normal_quantile(u.y)), m, slope_cholesky(S)));
}

// normal: of the facet; widest: covariance of what is rougher along one direction, by which that direction is known.
FittedFacet fitted_facet(uint fit, const float alpha, vec3 wo, const vec3 normal, const vec3 widest) {
    FittedFacet f;
    f.fit = fit;
    f.stretch = fit_stretch(fit, alpha);
    Frame frame = frame_about(normal);
    f.turn = transpose(mat3(frame.x, frame.y, frame.z));
    if (!fitted_is_round(fit) && abs(widest.x - widest.y) + abs(widest.z) > 1e-7) {
        float angle = 0.5 * atan(2.0 * widest.z, widest.x - widest.y) - fitted_direction(fit);
        float c = cos(angle), s = sin(angle);
        f.turn = mat3(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0) * f.turn;
    }
    f.wo = f.turn * wo;
    f.area = fitted_lobes_area(fit, f.wo, f.stretch);
    return f;
}

// Radiance towards the viewer per unit of irradiance on a plane that faces wi.
vec3 fitted_reflected(const FittedFacet f, vec3 wi) {
    wi = f.turn * wi;
    if (f.wo.z <= 0.0 || wi.z <= 0.0) {
        return vec3(0.0);
    }
    return fitted_fresnel(f.fit, 0.5 * length(f.wo + wi)) * fitted_mirrors(f.fit, f.wo, wi, f.stretch);
}

// Density by solid angle with which a direction is drawn.
float fitted_density(const FittedFacet f, vec3 wi) {
    wi = f.turn * wi;
    vec3 h = f.wo + wi;
    vec3 wn = h * inversesqrt(max(dot(h, h), 1e-20));
    return (1.0 - DEFENSIVE) * fitted_lobes_density(f.fit, f.wo, wn, f.area, f.stretch) + DEFENSIVE / LEADR_PI * max(wi.z, 0.0);
}

// A direction drawn for its mirrors.
vec3 fitted_direction_drawn(const FittedFacet f, const vec2 u) {
    if (u.x < DEFENSIVE) {
        return drawn_cosine(vec2(u.x / DEFENSIVE, u.y)) * f.turn;
    }
    // The choice of a lobe and the place on it share a number, which has digits for both.
    float choice = (u.x - DEFENSIVE) / (1.0 - DEFENSIVE) * 64.0;
    vec3 wn = fitted_lobes_normal(f.fit, f.wo, (floor(choice) + 0.5) / 64.0, vec2(fract(choice), u.y), f.area, f.stretch);
    vec3 wi = 2.0 * max(dot(f.wo, wn), 0.0) * wn - f.wo;
    return wi * f.turn;
}

#endif
