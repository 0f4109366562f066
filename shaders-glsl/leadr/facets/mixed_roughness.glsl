#ifndef LEADR_MIXED_ROUGHNESS_GLSL
#define LEADR_MIXED_ROUGHNESS_GLSL

// Mixes two base roughnesses on one surface, each with its own lobe. A map can filter these quantities linearly: the area fraction p of the
// rougher base, and the contributions of both bases to the mean alpha^2. crates/leadr-reflectance/src/facets/mixed_roughness.rs gives the
// derivation.

struct MixedRoughness {
    float share;        // area fraction of the rougher base, 0..1
    float smooth_alpha; // Beckmann alpha of the smoother base
    float rough_alpha;  // Beckmann alpha of the rougher base; both alphas are equal if one base has no area
};

const float LEADR_LEAST_SHARE = 1.0 / 512.0;

// Computes the two roughnesses from the filtered means: p, E[alpha^2 of the rough base] and E[alpha^2 of the smooth base].
MixedRoughness mixed_roughness(const vec3 means) {
    float share = clamp(means.x, 0.0, 1.0);
    float rough = sqrt(clamp(means.y, 0.0, share) / max(share, LEADR_LEAST_SHARE));
    float even = sqrt(clamp(means.z, 0.0, 1.0 - share) / max(1.0 - share, LEADR_LEAST_SHARE));
    if (share < LEADR_LEAST_SHARE) return MixedRoughness(0.0, even, even);
    if (share > 1.0 - LEADR_LEAST_SHARE) return MixedRoughness(1.0, rough, rough);
    return MixedRoughness(share, even, rough);
}

// Returns the Beckmann alpha of one lobe that replaces both lobes (LEADR section 4.1).
float joint_alpha(const MixedRoughness mixed) {
    return sqrt(mix(mixed.smooth_alpha * mixed.smooth_alpha, mixed.rough_alpha * mixed.rough_alpha, mixed.share));
}

#endif
