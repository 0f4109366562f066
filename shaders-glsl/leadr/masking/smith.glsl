#ifndef LEADR_MASKING_GLSL
#define LEADR_MASKING_GLSL

#include "../facets/projected_area.glsl"

// Smith masking and shadowing of a noncentral Gaussian surface (LEADR eq. 13-15), in a form where Lambda has no poles.

// Returns Lambda(w) of LEADR 4.3, or a large finite value where the paper has +infinity (a <= 0).
float smith_lambda(const vec3 w, const vec2 m, const vec3 S) {
    float a = meso_area(w, m);
    return rough_area(a, slope_spread(w, S)) / max(a, LEADR_MIN_AREA);
}

// Returns Walter's rational fit of Lambda, which LEADR 4.3 and its supplement (3.2) print. nu is a / (sqrt(2) b), with the projected area a
// of the mesosurface and the deviation b of the slopes along w. 1 / (1 + Lambda) errs by at most .0035.
float smith_lambda_fit(const float nu) {
    return nu < 1.6 ? (1.0 - 1.259 * nu + 0.396 * nu * nu) / (3.535 * nu + 2.181 * nu * nu) : 0.0;
}

// A visible area, at least MIN_AREA, written as a quotient of two positive numbers. The denominator is at least MIN_AREA^2. Callers can
// merge the quotient into their own divisions.
struct AreaQuotient {
    float over;
    float under;
};

// Returns A = a/2 + sqrt(a^2/4 + b^2 K(t^2)) with t = a/b and K = h (h + |t|), where h is the function h of rough_area. K is even in t,
// smooth in t^2, and 1/(2 pi) at t = 0. K is computed as 1/P^8, where the polynomial P is a minimax fit made for this project. Up to t =
// 4.7, the relative error of K is 1.5e-6. Above t = 4.7, the remainder of A beyond max(a, 0) is less than 1e-6 b. The fit needs no
// exponential and no division. For a < 0, the conjugate form avoids cancellation.
AreaQuotient visible_area_quotient(const vec3 w, const vec2 m, const vec3 S) {
    float a = meso_area(w, m);
    float b2 = max(slope_spread_squared(w, S), 1e-24);
    float s = min(a * a / b2, 22.09);
    // The polynomial is evaluated in pairs, whose dependency chain is half as long as in nested multiplication.
    float s2 = s * s;
    float p = (1.25826584 + 0.0897783514 * s) + s2 * ((0.00260910305 + 6.47612559e-5 * s)
            + s2 * ((8.69022102e-7 + 8.58237506e-9 * s) + s2 * 2.58387444e-10));
    p *= p;
    p *= p;
    float c = 0.5 * abs(a) * p;
    float sum = max(c + sqrt(c * c + b2), LEADR_MIN_AREA);
    float under = a < 0.0 ? p * sum : p;
    return AreaQuotient(max(a < 0.0 ? b2 : sum, LEADR_MIN_AREA * under), under);
}

// Returns 1 / A(wo) = (wm.wg / wm.wo) / (1 + Lambda(wo)), the factor of masking without shadowing, with the projected area of eq. 16.
float masking(const vec3 wo, const vec2 m, const vec3 S) {
    AreaQuotient o = visible_area_quotient(wo, m, S);
    return o.under / o.over;
}

// Returns 1 / (a_o (1 + Lambda_o + Lambda_i)), LEADR eq. 13 with the projected area of eq. 16, for height-correlated masking and shadowing.
// The result is 0 when the light is below the mesosurface. Without shadowing, the result is masking(wo).
float masking_shadowing(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const bool shadowing) {
    if (!shadowing) return masking(wo, m, S);
    float ao = max(meso_area(wo, m), 0.0);
    float ai = max(meso_area(wi, m), 0.0);
    float Ao = max(visible_area(wo, m, S), LEADR_MIN_AREA);
    return ai / max(ai * Ao + ao * rough_area(ai, slope_spread(wi, S)), 1e-30);
}

// Returns the value of shadowing_given_masking from terms of the viewer that are computed outside the loop: ao = meso_area(wo, m), Ao =
// visible_area(wo, m, S).
float shadowing_from_areas(const float ao, const float Ao, const vec3 wi, const vec2 m, const vec3 S) {
    float ai = max(meso_area(wi, m), 0.0);
    float lit = ai * max(Ao, LEADR_MIN_AREA);
    return lit / max(lit + max(ao, 0.0) * rough_area(ai, slope_spread(wi, S)), 1e-30);
}

// Returns (1 + Lambda_o) / (1 + Lambda_o + Lambda_i), the lit fraction of the visible area, 0..1, or 1 without shadowing. The fraction
// weights one sample (eq. 22) or one light (eq. 20) in a sum that already includes masking.
float shadowing_given_masking(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const bool shadowing) {
    return shadowing ? shadowing_from_areas(meso_area(wo, m), visible_area(wo, m, S), wi, m, S) : 1.0;
}

#endif
