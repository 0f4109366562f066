#ifndef LEADR_CLASS_SKY_GLSL
#define LEADR_CLASS_SKY_GLSL

#include "../facets/normal_length.glsl"

// Computes the sky that the facets of each class see, averaged over all facets of the class
// (crates/leadr-reflectance/src/masking/class_sky.rs).

// The sky above the classes of a footprint, independent of the viewer. Areas are relative to the mesosurface.
struct ClassSky {
    vec2 mean;    // mean slope of all facets
    vec4 area;    // share times facet area
    vec4 flux;    // share of the sky's flux; sums to one
    vec4 depth;   // optical depth towards the sky
    vec4 blocked; // fraction of the hemisphere, weighted by the cosine, that is blocked for the facets of a class
};

// Returns the sky of classes, from their shares, mean slopes, slope covariances and optical depths towards the sky. Shares sum to one, and
// are 0 beyond count. A constant count lets the compiler remove the loops over absent classes.
ClassSky class_sky(const int count, const vec4 share, const vec2 m[4], const vec3 S[4], const vec4 depth) {
    ClassSky sky;
    sky.depth = depth;
    sky.mean = vec2(0.0);
    for (int k = 0; k < 4; ++k) {
        if (k < count) sky.mean += share[k] * m[k];
    }
    float per_square = 1.0 / (1.0 + dot(sky.mean, sky.mean));
    float per_length = sqrt(per_square);
    sky.area = vec4(0.0);
    vec4 facing = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        if (k >= count) break;
        float area = mean_normal_length(m[k], S[k]) * per_length;
        float projected = (1.0 + dot(sky.mean, m[k])) * per_square;
        sky.area[k] = share[k] * area;
        facing[k] = share[k] * 0.5 * max(area + projected, 0.0);
    }
    sky.flux = facing / (1.0 + depth);
    sky.flux /= max(dot(sky.flux, vec4(1.0)), 1e-30);
    sky.blocked = clamp((sky.area - sky.flux) / max(sky.area, 1e-30), 0.0, 1.0);
    return sky;
}

#endif
