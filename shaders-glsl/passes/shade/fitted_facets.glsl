// Measured facets themselves, not their lobes: what samples of the reference see.
#ifndef LEADR_SHADE_FITTED_FACETS
#define LEADR_SHADE_FITTED_FACETS
#include "draws.glsl"
#include "surface.glsl"

// Share of the directions that are drawn from the hemisphere, for slopes that lobes have hardly any of.
const float DEFENSIVE = 0.125;

// A measured facet from where it is seen, in its own frame.
struct FittedFacet {
    uint fit;
    float stretch;
    vec2 turn;     // cosine and sine of the angle from the facet's frame to that of the table
    vec3 wo;       // in the table's
    float area;    // that wo sees of its lobes
};

vec3 turned(vec2 turn, vec3 w) {
    return vec3(turn.x * w.x + turn.y * w.y, turn.x * w.y - turn.y * w.x, w.z);
}

// widest: covariance of what is rougher along one direction, by which that direction is known.
FittedFacet fitted_facet(uint fit, float alpha, vec3 wo, vec3 widest) {
    FittedFacet f;
    f.fit = fit;
    f.stretch = fit_stretch(fit, alpha);
    f.turn = vec2(1.0, 0.0);
    if (abs(widest.x - widest.y) + abs(widest.z) > 1e-7) {
        float angle = 0.5 * atan(2.0 * widest.z, widest.x - widest.y) - fitted_direction(fit);
        f.turn = vec2(cos(angle), sin(angle));
    }
    f.wo = turned(f.turn, wo);
    f.area = fitted_lobes_area(fit, f.wo, f.stretch);
    return f;
}

// Radiance towards the viewer per unit of irradiance on a plane that faces wi, a direction of the facet's own frame.
vec3 fitted_reflected(FittedFacet f, vec3 wi) {
    wi = turned(f.turn, wi);
    return fitted_fresnel(f.fit, 0.5 * length(f.wo + wi)) * fitted_mirrors(f.fit, f.wo, wi, f.stretch);
}

// Density by solid angle with which a direction is drawn.
float fitted_density(FittedFacet f, vec3 wi) {
    vec3 h = f.wo + turned(f.turn, wi);
    vec3 wn = h * inversesqrt(max(dot(h, h), 1e-20));
    return (1.0 - DEFENSIVE) * fitted_lobes_density(f.fit, f.wo, wn, f.area, f.stretch) + DEFENSIVE / LEADR_PI * max(wi.z, 0.0);
}

// A direction drawn for its mirrors.
vec3 fitted_direction_drawn(FittedFacet f, vec2 u) {
    if (u.x < DEFENSIVE) {
        return drawn_cosine(vec2(u.x / DEFENSIVE, u.y));
    }
    // The choice of a lobe and the place on it share a number, which has digits for both.
    float choice = (u.x - DEFENSIVE) / (1.0 - DEFENSIVE) * 64.0;
    vec3 wn = fitted_lobes_normal(f.fit, f.wo, (floor(choice) + 0.5) / 64.0, vec2(fract(choice), u.y), f.area, f.stretch);
    vec3 wi = 2.0 * max(dot(f.wo, wn), 0.0) * wn - f.wo;
    return turned(vec2(f.turn.x, -f.turn.y), wi);
}

#endif
