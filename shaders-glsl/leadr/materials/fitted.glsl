#ifndef LEADR_FITTED_GLSL
#define LEADR_FITTED_GLSL

#include "../facets/beckmann.glsl"
#include "../facets/beckmann_sampling.glsl"
#include "../masking/variants.glsl"
#include "microfacet.glsl"

// A measured material, whose facets have a tabulated slope distribution (thesis chapter 4). The specular term is f_r cos(theta_i) = F D (G
// / a_o) / 4, and a diffuse base adds to it. The values of a material are consecutive words of a buffer that the includer defines:
//     layout(std430) readonly buffer Fits { float fits[]; };
//     #define LEADR_FITTED_WORD(i) fits[i]
// A material starts at the word `fit`. crates/leadr-reflectance/src/materials/fitted_table.rs writes these words:
//     0 masking   1 lobes   2 equivalent roughness alpha   3 direction of its widest slopes   4, 5 mean slope
//     6 intervals of ln D   7 azimuths   8 start of ln D   9 intervals of the visible area   10 its start
//     11 intervals of the Fresnel term   12 its start   13 GGX roughness   14 lobes: share, covariance xx, yy, xy, alpha
// Starts are relative to `fit`. ln D is sampled at theta = (i / n)^2 90 degrees, and the visible area at cos(theta) = (j / n)^2, each with
// its derivative. The Fresnel term is sampled at even steps of the angle, as r, g and b.
//
// stretch is the factor on the measured slopes; it is 1 for the unmodified material.

#ifndef LEADR_FITTED_WORD
#error define LEADR_FITTED_WORD(i) before this file: word i of the numbers of all fits
#endif

float fitted_word(const uint fit, const int i) {
    return LEADR_FITTED_WORD(fit + uint(i));
}

int fitted_masking(const uint fit) { return int(fitted_word(fit, 0)); }
int fitted_lobes(const uint fit) { return int(fitted_word(fit, 1)); }
float fitted_alpha(const uint fit) { return fitted_word(fit, 2); }
float fitted_direction(const uint fit) { return fitted_word(fit, 3); }
float fitted_ggx_alpha(const uint fit) { return fitted_word(fit, 13); }
bool fitted_is_round(const uint fit) { return fitted_word(fit, 7) < 1.5; }

struct FittedLobe {
    float share;
    vec3 S;      // covariance of the lobe's slopes
    float alpha; // roughness across the direction of the lobe's widest slopes
};

FittedLobe fitted_lobe(const uint fit, const int i, const float stretch) {
    int at = 14 + 5 * i;
    vec3 S = vec3(fitted_word(fit, at + 1), fitted_word(fit, at + 2), fitted_word(fit, at + 3));
    return FittedLobe(fitted_word(fit, at), S * (stretch * stretch), min(stretch * fitted_word(fit, at + 4), 2.0));
}

// Evaluates a cubic through knots at 0, 1, 2, ... The values of the knots start at `at`.
float fitted_curve(const uint fit, const int at, const int intervals, float x) {
    x = clamp(x, 0.0, float(intervals));
    int i = min(int(x), intervals - 1);
    int knot = at + 2 * i;
    float t = x - float(i), s = 1.0 - t;
    return (1.0 + 2.0 * t) * s * s * fitted_word(fit, knot) + t * s * s * fitted_word(fit, knot + 1)
         + t * t * (3.0 - 2.0 * t) * fitted_word(fit, knot + 2) - t * t * s * fitted_word(fit, knot + 3);
}

// Evaluates one cubic per azimuth for four azimuths, and interpolates between them by another cubic.
float fitted_rows(const uint fit, const int at, const int intervals, const float x, const vec2 towards) {
    int rows = int(fitted_word(fit, 7));
    if (rows == 1) return fitted_curve(fit, at, intervals, x);
    float position = fract(atan(towards.y, towards.x == 0.0 && towards.y == 0.0 ? 1.0 : towards.x) / 6.28318531) * float(rows);
    int k = min(int(position), rows - 1);
    float t = position - float(k);
    vec4 four;
    for (int i = 0; i < 4; ++i) {
        four[i] = fitted_curve(fit, at + 2 * (intervals + 1) * ((k + rows + i - 1) % rows), intervals, x);
    }
    return four.y + 0.5 * t * (four.z - four.x
         + t * (2.0 * four.x - 5.0 * four.y + 4.0 * four.z - four.w + t * (3.0 * (four.y - four.z) + four.w - four.x)));
}

// Returns D(wn), the density of normals per unit of macrosurface and solid angle.
float fitted_ndf(const uint fit, const vec3 wn, const float stretch) {
    if (wn.z <= 0.0) return 0.0;
    vec3 n = vec3(wn.xy / stretch, wn.z);
    float theta = atan(length(n.xy), n.z);
    int intervals = int(fitted_word(fit, 6));
    float x = sqrt(theta / 1.57079633) * float(intervals);
    float square = stretch * dot(n, n);
    return exp(fitted_rows(fit, int(fitted_word(fit, 8)), intervals, x, n.xy)) / (square * square);
}

// Returns the mean slope.
vec2 fitted_mean(const uint fit, const float stretch) {
    return stretch * vec2(fitted_word(fit, 4), fitted_word(fit, 5));
}

// Returns A(w), the visible area.
float fitted_area(const uint fit, const vec3 w, const float stretch) {
    vec2 mean = fitted_mean(fit, stretch);
    vec3 seen = vec3(stretch * w.xy, w.z);
    float l = length(seen);
    vec3 up = seen * ((w.z < 0.0 ? -1.0 : 1.0) / max(l, 1e-20));
    int intervals = int(fitted_word(fit, 9));
    float area = fitted_rows(fit, int(fitted_word(fit, 10)), intervals, sqrt(max(up.z, 0.0)) * float(intervals), up.xy);
    // Facets that face away from w face -w, so A(w) - A(-w) is the area of the mesosurface.
    float a = meso_area(w, mean);
    return max(l * area + (w.z < 0.0 ? a : 0.0), max(a, 0.0));
}

// Returns F at the cosine of wo and wh, in linear RGB.
vec3 fitted_fresnel(const uint fit, const float cosine) {
    int intervals = int(fitted_word(fit, 11));
    float c = clamp(cosine, 0.0, 1.0);
    // The polynomial approximates acos with an error of 2e-8 (Abramowitz and Stegun 4.4.46).
    float angle = sqrt(1.0 - c) * (1.5707963050 + c * (-0.2145988016 + c * (0.0889789874 + c * (-0.0501743046
                + c * (0.0308918810 + c * (-0.0170881256 + c * (0.0066700901 - c * 0.0012624911)))))));
    float x = angle / 1.57079633 * float(intervals);
    int i = clamp(int(x), 0, intervals - 1);
    int at = int(fitted_word(fit, 12)) + 3 * i;
    vec3 low = vec3(fitted_word(fit, at), fitted_word(fit, at + 1), fitted_word(fit, at + 2));
    vec3 high = vec3(fitted_word(fit, at + 3), fitted_word(fit, at + 4), fitted_word(fit, at + 5));
    return mix(low, high, clamp(x - float(i), 0.0, 1.0));
}

// Returns D (G / a_o) / 4, which is f_r cos(theta_i) for the material's specular term without F. The result is 0 for a half vector on or
// below the horizon.
float fitted_specular(const uint fit, const vec3 wo, const vec3 wi, const float stretch) {
    vec3 wh = half_vector(wo, wi);
    if (wh.z <= 0.0) return 0.0;
    float factor = masking_factor(fitted_masking(fit), wo, wi, wh, fitted_mean(fit, stretch), fitted_area(fit, wo, stretch),
                                  fitted_area(fit, wi, stretch), vec3(1.0, 1.0, 0.0));
    return microfacet_product(fitted_ndf(fit, wh, stretch), factor);
}

// Returns the sum of the visible areas of the Gaussian lobes. Specular directions are drawn from the visible normals of the lobes, and a
// lobe is chosen in proportion to its visible area. The next two functions take this sum as `area`.
float fitted_lobes_area(const uint fit, const vec3 wo, const float stretch) {
    float area = 0.0;
    for (int i = 0; i < fitted_lobes(fit); ++i) {
        FittedLobe lobe = fitted_lobe(fit, i, stretch);
        area += lobe.share * visible_area(wo, vec2(0.0), lobe.S);
    }
    return area;
}

// Returns a visible normal of one lobe for u in [0, 1)^2. `choice` in [0, 1) selects the lobe.
vec3 fitted_lobes_normal(const uint fit, const vec3 wo, const float choice, const vec2 u, const float area, const float stretch) {
    float rest = choice * area;
    int last = fitted_lobes(fit) - 1;
    FittedLobe lobe = fitted_lobe(fit, last, stretch);
    for (int i = 0; i < last; ++i) {
        FittedLobe other = fitted_lobe(fit, i, stretch);
        float part = other.share * visible_area(wo, vec2(0.0), other.S);
        if (rest < part) {
            lobe = other;
            break;
        }
        rest -= part;
    }
    return beckmann_sample_visible(wo, u, vec2(0.0), lobe.S);
}

// Returns the density of the drawn reflected directions per solid angle, where wn is the normal that reflects wo.
float fitted_lobes_density(const uint fit, const vec3 wo, const vec3 wn, const float area, const float stretch) {
    float d = 0.0;
    for (int i = 0; i < fitted_lobes(fit); ++i) {
        FittedLobe lobe = fitted_lobe(fit, i, stretch);
        d += lobe.share * beckmann_ndf(wn, vec2(0.0), lobe.S);
    }
    return 0.25 * min(d, 1e30) / max(area, LEADR_MIN_AREA);
}

#endif
