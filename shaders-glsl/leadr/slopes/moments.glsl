#ifndef LEADR_SLOPE_MOMENTS_GLSL
#define LEADR_SLOPE_MOMENTS_GLSL

#include "statistics.glsl"

#ifndef LEADR_PRECISE
#define LEADR_PRECISE
#endif

// The algebra of slope moments (LEADR 4.1-4.2; thesis 3.3, 3.4 and 5.1), explained in crates/leadr-reflectance/src/slopes/moments.rs. If means
// are steep, subtracting their squares loses small variances. Therefore, prefer mean and covariance where a pixel has a single surface.

struct SlopeMoments {
    vec2 first;  // E[x], E[y]: the mean slope
    vec3 second; // E[x^2], E[y^2], E[xy]
};

// Returns the moments of one slope sample.
SlopeMoments moments_of_slope(const vec2 slope) {
    return SlopeMoments(slope, vec3(slope * slope, slope.x * slope.y));
}

// Returns the slope of a normal of any length, clamped to MAX_SLOPE. A normal below the horizon is moved onto it.
vec2 slope_of_normal(vec3 n) {
    n *= inversesqrt(max(dot(n, n), 1e-30));
    vec2 slope = -n.xy / max(n.z, LEADR_MIN_NORMAL_Z);
    return slope * min(1.0, LEADR_MAX_SLOPE * inversesqrt(max(dot(slope, slope), 1e-12)));
}

// Returns the moments of one texel of a normal map (thesis, listing 3.7).
SlopeMoments moments_of_normal(const vec3 n) {
    return moments_of_slope(slope_of_normal(n));
}

// Returns the slope by central differences. `heights` has the heights of the neighbours at -s, +s, -t and +t, and `spacing` is the distance
// between neighbouring texels.
vec2 slope_of_heights(const vec4 heights, const vec2 spacing) {
    return (heights.yw - heights.xz) / max(2.0 * spacing, 1e-12);
}

// Returns the moments of a height field over the quarter of a cell at its first corner. A cell has four triangles, which meet in its
// centre at the mean height of its corners. `heights` has the height at this corner, and the heights one texel further along s, along t,
// and along both. `spacing` is the distance between texels, and negative if s or t runs backwards. Differences are bounded to 1e18. If
// LEADR_PRECISE is defined as `precise`, all devices return the same result.
SlopeMoments moments_of_corner(const vec4 heights, const vec2 spacing) {
    LEADR_PRECISE vec2 beside = clamp((heights.yz - heights.x) / spacing, -1e18, 1e18);
    LEADR_PRECISE vec2 opposite = clamp((heights.w - heights.zy) / spacing, -1e18, 1e18);
    LEADR_PRECISE vec2 mean = 0.5 * (beside + opposite);
    LEADR_PRECISE vec2 first = 0.5 * (beside + mean);
    LEADR_PRECISE vec2 squares = 0.5 * (beside * beside + mean * mean);
    LEADR_PRECISE float mixed = 0.5 * (beside.x * mean.y + mean.x * beside.y);
    return SlopeMoments(first, vec3(squares, mixed));
}

// Returns the moments of the sum of two displacements with independent slopes (thesis 5.1; the erratum of its listing is corrected).
SlopeMoments add_moments(const SlopeMoments a, const SlopeMoments b) {
    vec3 mixed = vec3(2.0 * a.first * b.first, a.first.x * b.first.y + a.first.y * b.first.x);
    return SlopeMoments(a.first + b.first, a.second + b.second + mixed);
}

// Returns the moments of heights multiplied by eta (LEADR 4.2, Height Scaling).
SlopeMoments scale_moments(const SlopeMoments a, const float eta) {
    return SlopeMoments(a.first * eta, a.second * (eta * eta));
}

// Returns the moments of heights with a plane of slope `shear` added.
SlopeMoments shear_moments(const SlopeMoments a, const vec2 shear) {
    return add_moments(a, moments_of_slope(shear));
}

// Returns the moments of a Gaussian of mean slope m and covariance S (thesis eq. 3.5-3.9 with S = alpha^2 / 2).
SlopeMoments moments_of_distribution(const vec2 m, const vec3 S) {
    return shear_moments(SlopeMoments(vec2(0.0), S), m);
}

// Returns the moments of a surface that consists of b on the fraction t of its area, and of a elsewhere.
SlopeMoments mix_moments(const SlopeMoments a, const SlopeMoments b, const float t) {
    return SlopeMoments(mix(a.first, b.first, t), mix(a.second, b.second, t));
}

// Returns the moments of slopes multiplied by an independent mask. `mask` has the mean of the mask and the mean of the squared mask.
SlopeMoments mask_moments(const SlopeMoments a, const vec2 mask) {
    return SlopeMoments(a.first * mask.x, a.second * mask.y);
}

// Returns the moments of the slopes linear * (h_s, h_t) (LEADR eq. 12).
SlopeMoments map_moments(const mat2 linear, const SlopeMoments a) {
    return SlopeMoments(linear * a.first, map_second_moments(linear, a.second));
}

// Returns the moments after adding a base material of Beckmann roughness alpha, whose slope variance is sigma^2 = alpha^2 / 2.
SlopeMoments roughen_moments(const SlopeMoments a, const float alpha) {
    return SlopeMoments(a.first, a.second + vec3(vec2(0.5 * alpha * alpha), 0.0));
}

// Returns the covariance of the slopes in any unit, like covariance_from_moments (LEADR eq. 9).
vec3 moments_covariance(const SlopeMoments a) {
    return covariance_from_moments(a.first, a.second);
}

#endif
