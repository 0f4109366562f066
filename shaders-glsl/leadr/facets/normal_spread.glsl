#ifndef LEADR_NORMAL_SPREAD_GLSL
#define LEADR_NORMAL_SPREAD_GLSL

// Estimates roughness from the length of a mean normal, given as the shortening, 1 - length.
// crates/leadr-reflectance/src/facets/normal_spread.rs gives the validity of the estimates.

// Returns the concentration of the von Mises-Fisher lobe with a mean of length L: L (3 - L^2) / (1 - L^2) (Banerjee et al. 2005). The
// estimate is up to 5 % too large, and is clamped to 1e-9..1e9.
float vmf_kappa_estimate(const float shortening) {
    float held = clamp(shortening, 0.0, 1.0);
    float len = 1.0 - held;
    return clamp(len * (3.0 - len * len) / max(held * (1.0 + len), 1e-12), 1e-9, 1e9);
}

// Returns Toksvig's factor of a Blinn-Phong exponent, from 0 to 1.
float toksvig_factor(const float shortening, const float exponent) {
    float held = clamp(shortening, 0.0, 1.0);
    return (1.0 - held) / max((1.0 - held) + clamp(exponent, 0.0, 1e18) * held, 1e-30);
}

// Returns Toksvig's estimate of the variance of normals per axis, at most 1e6.
float toksvig_normal_variance(const float shortening) {
    float held = clamp(shortening, 0.0, 1.0);
    return held / max(1.0 - held, 1e-6);
}

#endif
