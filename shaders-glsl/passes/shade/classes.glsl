// The classes of facets under a pixel, each shaded as a surface of its own (leadr/masking/classes.glsl).
#ifndef LEADR_SHADE_CLASSES
#define LEADR_SHADE_CLASSES
#include "lighting.glsl"

// The lights of the pixel, which all classes share, and the fraction of each class that they light.
Light class_lights[LIGHTS > 0 ? LIGHTS : 1];
vec4 class_lights_lit[LIGHTS > 0 ? LIGHTS : 1];

#ifdef LEADR_CLASS_OPENNESS
vec4 class_openness_at(const vec2 at) {
    return textureLod(class_openness, at, 0.0);
}
#else
vec4 class_openness_at(const vec2 at) {
    return vec4(1.0);
}
#endif

// Returns the openness of the classes towards w.
ClassesSeen classes_towards(const Surface surface, const vec3 w) {
    FacetClasses c = surface.classes;
    float up = w.z - dot(c.offset, w.xy);
    vec2 q = vec2(dot(c.s, w.xy), dot(c.t, w.xy));
    vec4 of_map = class_openness_at(0.5 + 0.5 * q / (length(q) + max(up, 1e-4)));
    vec4 open = vec4(of_map[c.number[0]], of_map[c.number[1]], of_map[c.number[2]], of_map[c.number[3]]);
    ClassesSeen seen;
    seen.open = up > 0.0 ? openness_inside(clamp(open, 0.0, 1.0), c.inside) : vec4(0.0);
    seen.whitened = whitened_direction(w, surface.whole_cholesky);
    seen.lambda = classes_lambda(seen.open, vec4(c.share[0], c.share[1], c.share[2], c.share[3]));
    return seen;
}

// Prepares the shading of the classes, and returns the share of each in the visible area.
vec4 classes_seen(inout Surface surface) {
    FacetClasses c = surface.classes;
    vec4 share = vec4(c.share[0], c.share[1], c.share[2], c.share[3]);
    if (!BY_CLASS) {
        return share;
    }
    surface.whole_cholesky = slope_cholesky(surface.slope_covariance);
    surface.seen = classes_towards(surface, surface.wo);
    for (int k = 0; k < c.count; ++k) {
        share[k] *= visible_area(surface.wo, c.mean[k], c.covariance[k]) * max(surface.seen.open[k], 1e-3);
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

// Returns the fraction of the visible facets of each class that are lit from wi.
vec4 classes_lit(const Surface surface, const vec3 wi) {
    return class_lit_fractions(SHADOWING, surface.seen, classes_towards(surface, wi));
}

// Returns the fraction of the visible facets of the shaded class that are lit from wi.
float class_lit(const Surface surface, const vec3 wi) {
    return classes_lit(surface, wi)[surface.part];
}

// Returns the fraction of the environment's diffuse light that arrives on the visible facets of the class.
float class_sky_open(const Surface surface) {
    float lit = 0.0, all = 0.0;
    for (int i = 0; i < 12; ++i) {
        float azimuth = LEADR_PI * (0.25 + 0.5 * float(i & 3)), height = float(i >> 2) - 1.0;
        vec3 wi = vec3(vec2(cos(azimuth), sin(azimuth)), 0.5 + 0.3873 * height);
        wi.xy *= sqrt(1.0 - wi.z * wi.z);
        float facing = (8.0 - 3.0 * abs(height)) * visible_area(wi, surface.mean_slope, surface.slope_covariance);
        lit += facing * class_lit(surface, wi);
        all += facing;
    }
    return lit / max(all, 1e-6);
}

#endif
