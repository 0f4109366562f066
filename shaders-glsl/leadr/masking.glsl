#ifndef LEADR_MASKING_GLSL
#define LEADR_MASKING_GLSL

#include "projected_area.glsl"

// Smith masking and shadowing of a noncentral Gaussian surface (LEADR eq. 13-15), without the poles of Lambda.

// Lambda(w) of LEADR 4.3; where the paper has +infinity (a <= 0) a large finite value.
float smith_lambda(vec3 w, vec2 m, vec3 S) {
    float a = meso_area(w, m);
    return rough_area(a, slope_spread(w, S)) / max(a, LEADR_MIN_AREA);
}

// 1 / A(wo) = (wm.wg / wm.wo) / (1 + Lambda(wo)): masking alone, with the projected area of eq. 16.
float masking(vec3 wo, vec2 m, vec3 S) {
    return 1.0 / max(visible_area(wo, m, S), LEADR_MIN_AREA);
}

// 1 / (a_o (1 + Lambda_o + Lambda_i)), LEADR eq. 13 with the projected area of eq. 16: height-correlated masking and
// shadowing. 0 when the light is below the mesosurface. Without shadowing: masking(wo).
float masking_shadowing(vec3 wo, vec3 wi, vec2 m, vec3 S, bool shadowing) {
    if (!shadowing) return masking(wo, m, S);
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    float Ao = max(visible_area(wo, m, S), LEADR_MIN_AREA);
    return ai / max(ai * Ao + ao * rough_area(ai, slope_spread(wi, S)), 1e-30);
}

// shadowing_given_masking with what depends on the viewer alone computed outside the loop: ao = meso_area(wo, m),
// Ao = visible_area(wo, m, S).
float shadowing_from_areas(float ao, float Ao, vec3 wi, vec2 m, vec3 S) {
    float ai = max(meso_area(wi, m), 0.0);
    float lit = ai * max(Ao, LEADR_MIN_AREA);
    return lit / max(lit + max(ao, 0.0) * rough_area(ai, slope_spread(wi, S)), 1e-30);
}

// (1 + Lambda_o) / (1 + Lambda_o + Lambda_i): the part of what the viewer sees that the light reaches, 0..1. The weight
// of one sample (eq. 22) or one light (eq. 20) in a sum that is already normalised for masking. 1 without shadowing.
float shadowing_given_masking(vec3 wo, vec3 wi, vec2 m, vec3 S, bool shadowing) {
    return shadowing ? shadowing_from_areas(meso_area(wo, m), visible_area(wo, m, S), wi, m, S) : 1.0;
}

#endif
