// The classes of facets under a pixel, each shaded as a surface of its own (leadr/masking/classes.glsl).
#ifndef LEADR_SHADE_CLASSES
#define LEADR_SHADE_CLASSES
#include "lighting.glsl"
#include "leadr/visible/class_environment.glsl"

// The lights of the pixel, which all classes share, and the openness of the classes towards them.
Light pixel_lights[LIGHTS > 0 ? LIGHTS : 1];
vec4 pixel_lights_open[LIGHTS > 0 ? LIGHTS : 1];

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
    surface.whole_mean = surface.mean_slope;
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
    float open = class_open(surface.classes, k, of_map);
    return class_lit_fraction(SHADOWING, surface.classes.correlation[k], surface.seen[k], open, surface.whitened, whitened);
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

// Returns the environment that the visible facets of the shaded class see.
ClassEnvironment class_environment_of(const Surface surface) {
    int k = surface.part;
    return class_environment(surface.wo, surface.mean_slope, surface.slope_covariance, surface.whole_mean, surface.seen[k],
                             surface.classes.sky_depth[k]);
}

#endif
