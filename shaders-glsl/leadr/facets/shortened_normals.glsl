#ifndef LEADR_SHORTENED_NORMALS_GLSL
#define LEADR_SHORTENED_NORMALS_GLSL

#include "gloss.glsl"
#include "normal_distribution.glsl"

// Relates the length of the facets' mean normal to the roughness (Chan 2018, section 2).
// crates/leadr-reflectance/src/facets/shortened_normals.rs has the derivations.
//
// A length near 1 has few significant digits in 32 bits, so the functions use the shortening, 1 - length. For a filtered normal n, 1 - |n|
// has a rounding error of 6e-8, half a percent of the shortening at alpha = .0014.

// Combinations of a facet distribution and an area weighting, in the order of Shortening::ALL.
const int LEADR_GGX_MACRO = 0;
const int LEADR_GGX_MICRO = 1;
const int LEADR_BECKMANN_MACRO = 2;
const int LEADR_BECKMANN_MICRO = 3;

// The value of |1 - alpha^2| below which series replace the closed forms.
const float LEADR_LENGTH_SERIES_END = 0.25;

// Returns T = atanh(sqrt(e)) / sqrt(e) for e = 1 - square, or T = atan(sqrt(-e)) / sqrt(-e) for square > 1. square is alpha^2.
float atanh_ratio(const float square) {
    float e = 1.0 - square;
    if (abs(e) < LEADR_LENGTH_SERIES_END) {
        float tail = 1.0 / 15.0 + e * (1.0 / 17.0 + e * (1.0 / 19.0 + e * (1.0 / 21.0 + e / 23.0)));
        tail = 1.0 / 9.0 + e * (1.0 / 11.0 + e * (1.0 / 13.0 + e * tail));
        return 1.0 + e * (1.0 / 3.0 + e * (1.0 / 5.0 + e * (1.0 / 7.0 + e * tail)));
    }
    if (e > 0.0) {
        float a = sqrt(e);
        return log((1.0 + a) / sqrt(square)) / a;
    }
    // The built-in atan may err by 4096 ulp, so the code halves the angle twice and uses the series.
    float b = sqrt(-e);
    float half_tangent = b / (1.0 + sqrt(square));
    float t = half_tangent / (1.0 + sqrt(1.0 + half_tangent * half_tangent));
    float u = t * t;
    float tail = 1.0 / 9.0 - u * (1.0 / 11.0 - u * (1.0 / 13.0 - u / 15.0));
    return 4.0 * t / b * (1.0 - u * (1.0 / 3.0 - u * (1.0 / 5.0 - u * (1.0 / 7.0 - u * tail))));
}

// Returns (1 - L) / L = alpha^2 T of GGX facets weighted by microsurface area (Chan eq. 24). square is alpha^2.
float ggx_normal_odds_micro(const float square) {
    return square * atanh_ratio(square);
}

// Returns (1 - L) / L of GGX facets weighted by macrosurface area (Chan eq. 26).
float ggx_normal_odds_macro(const float square) {
    float e = 1.0 - square;
    if (abs(e) < LEADR_LENGTH_SERIES_END) {
        float tail = 1.0 / 17.0 + e * (1.0 / 19.0 + e * (1.0 / 21.0 + e * (1.0 / 23.0 + e / 25.0)));
        tail = 1.0 / 11.0 + e * (1.0 / 13.0 + e * (1.0 / 15.0 + e * tail));
        float one_minus_length = square * (1.0 / 3.0 + e * (1.0 / 5.0 + e * (1.0 / 7.0 + e * (1.0 / 9.0 + e * tail))));
        return one_minus_length / (1.0 - one_minus_length);
    }
    float ratio = atanh_ratio(square);
    return square * (ratio - 1.0) / (1.0 - square * ratio);
}

// Returns (1 - L, L) of Beckmann facets weighted by macrosurface area, both at full precision.
vec2 beckmann_shortening_length(const float square) {
    float u = 0.5 * square;
    if (u < 1.0 / 169.0) {
        // Mills' asymptotic series applies beyond the range of the rational fits.
        float one_minus_length = u * (1.0 - u * (3.0 - u * (15.0 - u * (105.0 - u * 945.0))));
        return vec2(one_minus_length, 1.0 - one_minus_length);
    }
    float t = inversesqrt(u);
    float one_minus_length = tail_mean_ratio(t);
    return vec2(one_minus_length, t < 2.0 ? t * mills_ratio(t) : 1.0 - one_minus_length);
}

// Returns (1 - L) / L of Beckmann facets weighted by macrosurface area.
float beckmann_normal_odds_macro(const float square) {
    vec2 parts = beckmann_shortening_length(square);
    return parts.x / parts.y;
}

// Returns (1 - L) / L of Beckmann facets weighted by microsurface area. The result is alpha^2 / 2 times the length for macrosurface area.
float beckmann_normal_odds_micro(const float square) {
    return 0.5 * square * beckmann_shortening_length(square).y;
}

// Returns (1 - L) / L for one of the four combinations.
float normal_odds(const int shortening, const float alpha) {
    float used = usable_alpha(alpha);
    float square = used * used;
    if (shortening == LEADR_GGX_MACRO) return ggx_normal_odds_macro(square);
    if (shortening == LEADR_GGX_MICRO) return ggx_normal_odds_micro(square);
    if (shortening == LEADR_BECKMANN_MACRO) return beckmann_normal_odds_macro(square);
    return beckmann_normal_odds_micro(square);
}

// Returns the shortening 1 - L.
float normal_shortening(const int shortening, const float alpha) {
    float odds = normal_odds(shortening, alpha);
    return odds / (1.0 + odds);
}

// Returns the length L.
float normal_length(const int shortening, const float alpha) {
    return 1.0 / (1.0 + normal_odds(shortening, alpha));
}

// Returns the derivative of log odds by log alpha^2, between 1 for smooth facets and 1/2 for rough ones. `odds` is (1 - L) / L at this
// alpha^2 (`square`).
float normal_odds_slope(const int shortening, const float square, const float odds) {
    if (shortening == LEADR_GGX_MICRO) {
        return 1.0 - 0.5 * square / (odds * (1.0 + ggx_normal_odds_macro(square)));
    }
    if (shortening == LEADR_GGX_MACRO) {
        float e = 1.0 - square;
        float len = 1.0 / (1.0 + odds);
        float one_minus_length = odds * len;
        // The derivative of the shortening with respect to alpha^2. Near alpha = 1 it is computed by a series.
        float change = abs(e) < 0.05 ? 2.0 / 15.0 + e * (4.0 / 35.0 + e * (6.0 / 63.0))
                                     : one_minus_length / square - (0.5 * len - one_minus_length) / e;
        return change * square / (one_minus_length * len);
    }
    vec2 parts = beckmann_shortening_length(square);
    // The derivative of the shortening with respect to log alpha^2. Smooth facets use a series, because the closed form cancels.
    float change = square < 0.01 ? parts.x - square * square * (0.75 - 3.75 * square) : 0.5 * parts.y - parts.x / square;
    return shortening == LEADR_BECKMANN_MACRO ? change / (parts.x * parts.y) : 1.0 - change / parts.y;
}

// Returns the alpha, from 1e-4 to 100, of facets whose mean normal has this shortening. The shortening is clamped to 0..1. Newton's method
// works on logarithms, where the curve is nearly straight: after three steps the error is 7e-11 in exact arithmetic.
float alpha_of_shortening(const int shortening, const float one_minus_length) {
    float held = clamp(one_minus_length, 0.0, 1.0);
    float odds = clamp(held / max(1.0 - held, 1e-9), 1e-12, 1e9);
    float wanted = log(odds);
    float square = clamp(odds * (1.0 + 0.4 * odds), LEADR_MIN_VARIANCE, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE);
    for (int i = 0; i < 3; i++) {
        float found = normal_odds(shortening, sqrt(square));
        float slope = clamp(normal_odds_slope(shortening, square, found), 0.4, 1.1);
        square *= exp(clamp((wanted - log(found)) / slope, -4.0, 4.0));
        square = clamp(square, LEADR_MIN_VARIANCE, LEADR_MAX_SLOPE * LEADR_MAX_SLOPE);
    }
    return usable_alpha(sqrt(square));
}

// Returns the alpha of a surface whose facets consist of facets of another roughness. The lengths of the mean normals multiply (Chan eq.
// 34).
float combine_alpha(const int shortening, const float alpha, const float other) {
    float a = normal_shortening(shortening, alpha);
    float b = normal_shortening(shortening, other);
    return alpha_of_shortening(shortening, a + b - a * b);
}

// Returns the alpha of GGX facets weighted by macrosurface area. The fit costs two roots and a rational function, and has a relative error
// of 1e-4. The alpha is clamped to .0027..1, which corresponds to a shortening of 4e-5..1/3.
float ggx_alpha_of_shortening_fit(const float one_minus_length) {
    float held = clamp(one_minus_length, 4.08e-5, 0.33333333);
    float x = sqrt(sqrt(held));
    float p = 0.0996729 + x * (1.6538365 + x * (-0.3396555 - x * 0.7129373));
    float q = 1.0 + x * (4.5496497 + x * (-12.7359867 + x * 7.2458094));
    return sqrt(held * p / q);
}

// Returns the gloss of a detail on a base, on the scale of LEADR_GLOSS_WWII (Chan 2018, eq. 35 to 37 and listing 2). The fit differs from
// combine_alpha by up to .0167 in gloss.
float chan_combine_gloss(const float base, const float detail) {
    float a = clamp(base, 0.0, 1.0);
    float b = clamp(detail, 0.0, 1.0);
    float sum = a + b;
    float squares = a * a + b * b;
    float product = a * b;
    float above = -0.535580 + 1.002204 * sum - 0.223910 * squares + 13.323150 * product;
    float below = 1.0 + 8.259559 * sum + 9.896132 * squares - 22.015902 * product;
    return clamp(above / below, 0.0, 1.0);
}

#endif
