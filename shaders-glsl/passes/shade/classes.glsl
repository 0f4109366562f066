// The classes of facets under a pixel, each shaded as a surface of its own (leadr/masking/classes.glsl).
#ifndef LEADR_SHADE_CLASSES
#define LEADR_SHADE_CLASSES
#include "lighting.glsl"
#include "leadr/visible/diffuse.glsl"
#include "leadr/visible/slopes.glsl"

// The lights of the pixel, which all classes share, and the openness of the classes towards them.
Light class_lights[LIGHTS > 0 ? LIGHTS : 1];
vec4 class_lights_open[LIGHTS > 0 ? LIGHTS : 1];

#ifdef LEADR_CLASS_OPENNESS
vec4 class_openness_at(const vec2 at) {
    return textureLod(class_openness, at, 0.0);
}
#else
vec4 class_openness_at(const vec2 at) {
    return vec4(1.0);
}
#endif

// Returns the openness of the classes towards w, in the order of the maps.
vec4 classes_open(const FacetClasses c, const vec3 w) {
    float up = w.z - dot(c.offset, w.xy);
    vec2 q = vec2(dot(c.s, w.xy), dot(c.t, w.xy));
    vec4 open = class_openness_at(0.5 + 0.5 * q / (length(q) + max(up, 1e-4)));
    return up > 0.0 ? open : vec4(0.0);
}

// Returns the openness of one class. of_map is the openness in the order of the maps.
float class_open(const FacetClasses c, const int k, const vec4 of_map) {
    return openness_inside(of_map[c.number[k]], c.inside);
}

// Prepares the shading of the classes, and returns the share of each in the visible area.
vec4 classes_seen(inout Surface surface) {
    FacetClasses c = surface.classes;
    vec4 share = vec4(c.share[0], c.share[1], c.share[2], c.share[3]);
    if (!BY_CLASS) {
        return share;
    }
    surface.whole_cholesky = slope_cholesky(surface.slope_covariance);
    surface.whitened = whitened_direction(surface.wo, surface.whole_cholesky);
    vec4 of_map = classes_open(c, surface.wo);
    for (int k = 0; k < c.count; ++k) {
        surface.seen[k] = max(class_open(c, k, of_map), 1e-3);
        share[k] *= visible_area(surface.wo, c.mean[k], c.covariance[k]) * surface.seen[k];
    }
    return share / max(dot(share, vec4(1.0)), 1e-9);
}

// Returns the surface that consists of one class only.
Surface class_part(Surface surface, const int k) {
    surface.part = k;
    surface.mean_slope = surface.classes.mean[k];
    surface.slope_covariance = surface.classes.covariance[k];
    surface.albedo = surface.classes.material[k].rgb;
    surface.alpha = surface.classes.material[k].a;
    return surface;
}

// Returns the fraction of the visible facets of class k that are lit from wi. of_map is the openness towards wi.
float class_lit(const Surface surface, const int k, const vec3 wi, const vec4 of_map) {
    vec2 whitened = whitened_direction(wi, surface.whole_cholesky);
    return class_lit_fraction(SHADOWING, surface.seen[k], class_open(surface.classes, k, of_map), surface.whitened, whitened);
}

// Returns the fraction of the visible facets of the shaded class that are lit from wi.
float class_lit(const Surface surface, const vec3 wi) {
    return class_lit(surface, surface.part, wi, classes_open(surface.classes, wi));
}

// Returns the fraction of the base's facets that are lit from wi, among those that are visible, on the shaded class.
float class_base_lit(const Surface surface, const vec3 wi) {
    vec2 m = surface.mean_slope;
    vec3 cholesky = vec3(0.70710678 * surface.alpha, 0.0, 0.70710678 * surface.alpha);
    return lit_fraction(SHADOWING, direction_area(surface.wo, m, cholesky), direction_area(wi, m, cholesky));
}

// The directions of this integral: elevations of a Gauss-Legendre rule, and azimuths that are shifted from row to row.
const int SKY_AZIMUTHS = 5;
const int SKY_ROWS = 3;
// The standard deviation of the environment's light in each direction, per sine of its elevation, in radians. Light from beyond the horizon
// must not mix in.
const float SKY_DEVIATION = 0.5;

// The environment that is hidden from the visible facets of the classes, for diffuse light.
struct ClassesHidden {
    vec3 radiance[MOST_CLASSES]; // mean radiance over all directions, weighted by the irradiance, where only hidden ones count
    vec4 share;                  // share of the irradiance of a constant environment
};

// Returns the visible area of Gaussian slopes, with an error of at most 3 % of their deviation.
float near_visible_area(const vec3 w, const SlopeGaussian g) {
    float a = meso_area(w, g.m);
    return 0.5 * (a + sqrt(a * a + 0.63661977 * slope_spread_squared(w, g.S)));
}

ClassesHidden classes_hidden(const Surface surface) {
    FacetClasses c = surface.classes;
    SlopeGaussian seen[MOST_CLASSES];
    ClassesHidden hidden;
    for (int k = 0; k < MOST_CLASSES; ++k) {
        hidden.radiance[k] = vec3(0.0);
    }
    for (int k = 0; k < c.count; ++k) {
        // One exponential approximates the factor 1/|N| of the irradiance about the mean of |N|^2.
        VisibleSlopes v = visible_slopes(surface.wo, c.mean[k], c.covariance[k]);
        seen[k] = damped_gaussian(v.mean, v.cov, 0.5 / squared_normal_spread(v.mean, v.cov).x);
    }
    vec4 all = vec4(0.0);
    hidden.share = vec4(0.0);
    for (int i = 0; i < SKY_ROWS * SKY_AZIMUTHS; ++i) {
        float row = float(i / SKY_AZIMUTHS) - 1.0, turn = float(i % SKY_AZIMUTHS) + row / float(SKY_ROWS);
        float azimuth = 2.0 * LEADR_PI / float(SKY_AZIMUTHS) * turn;
        float z = 0.5 + 0.38729833 * row, weight = 8.0 - 3.0 * abs(row);
        vec3 wi = vec3(sqrt(1.0 - z * z) * vec2(cos(azimuth), sin(azimuth)), z);
        vec4 of_map = classes_open(c, wi);
        float variance = SKY_DEVIATION * SKY_DEVIATION * z * z;
        vec3 sky = lobe_radiance(surface, wi, variance), ground = lobe_radiance(surface, -wi, variance);
        for (int k = 0; k < c.count; ++k) {
            float above = weight * near_visible_area(wi, seen[k]);
            float below = max(above - weight * meso_area(wi, seen[k].m), 0.0);
            float lost = above * (1.0 - class_lit(surface, k, wi, of_map));
            all[k] += above + below;
            hidden.share[k] += lost + below;
            hidden.radiance[k] += lost * sky + below * ground;
        }
    }
    for (int k = 0; k < c.count; ++k) {
        hidden.radiance[k] /= max(all[k], 1e-6);
    }
    hidden.share /= max(all, vec4(1e-6));
    return hidden;
}

#endif
