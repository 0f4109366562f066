// The classes of facets under a pixel, each shaded as a surface of its own (leadr/masking/classes.glsl).
#ifndef LEADR_SHADE_CLASSES
#define LEADR_SHADE_CLASSES
#include "harmonics.glsl"
#include "lighting.glsl"
#include "leadr/visible/class_environment.glsl"

// The lights of the pixel, which all classes share, and the openness of the classes towards them.
Light pixel_lights[LIGHTS > 0 ? LIGHTS : 1];
vec4 pixel_lights_open[LIGHTS > 0 ? LIGHTS : 1];
// The environment in directions of the sky.
struct PixelSky {
    vec3 direction[LEADR_SKY_DIRECTIONS];
    vec3 radiance[LEADR_SKY_DIRECTIONS];
    vec4 open[LEADR_SKY_DIRECTIONS];
    float decorrelation[LEADR_SKY_DIRECTIONS];
    // From below the mesosurface: near it, and the mean.
    vec3 down[LEADR_GROUND_DIRECTIONS];
    vec3 ground[LEADR_GROUND_DIRECTIONS];
    vec3 below;
};
PixelSky pixel_sky;
// The class that is shaded.
struct ShadedClass {
    int number;
    float depth;       // optical depth towards the viewer
    float correlation; // of the openness towards different directions
};
ShadedClass shaded_class;
vec4 pixel_depth; // optical depths of the classes towards the viewer

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
vec4 classes_open(const vec3 w) {
    float up = w.z - dot(pixel_classes.offset, w.xy);
    int views = TRIPLANAR ? pixel_classes.views : 1;
    vec4 open = vec4(0.0);
    for (int i = 0; i < views; ++i) {
        vec2 q = vec2(dot(pixel_classes.s[i], w.xy), dot(pixel_classes.t[i], w.xy));
        open += pixel_classes.weight[i] * class_openness_at(0.5 + 0.5 * q / (length(q) + max(up, 1e-4)));
    }
    return up > 0.0 ? open : vec4(0.0);
}

// Returns the optical depth of a class. of_map is the openness of all classes on the map.
float class_depth(const int k, const vec4 of_map) {
    return depth_inside(of_map[k], pixel_classes.inside);
}

// Prepares the shading of the classes, and returns the share of each in the visible area.
vec4 classes_seen(inout Surface surface) {
    vec4 share = pixel_classes.share;
    if (!BY_CLASS) {
        return share;
    }
    surface.whole_mean = surface.mean_slope;
    surface.whole_cholesky = slope_cholesky(surface.slope_covariance);
    surface.whitened = whitened_direction(surface.wo, surface.whole_cholesky);
    vec4 of_map = classes_open(surface.wo);
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        pixel_depth[k] = class_depth(k, of_map);
        share[k] *= visible_area(surface.wo, pixel_classes.mean[k], pixel_classes.covariance[k]) / (1.0 + pixel_depth[k]);
    }
    return share / max(dot(share, vec4(1.0)), 1e-9);
}

// Returns the surface that consists of one class only. Drivers would keep arrays with variable indices in memory.
Surface class_part(Surface surface, const int number) {
    shaded_class = ShadedClass(number, pixel_depth[number], pixel_classes.correlation[number]);
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        if (k == number) {
            surface.mean_slope = pixel_classes.mean[k];
            surface.slope_covariance = pixel_classes.covariance[k];
            surface.albedo = pixel_classes.material[k].rgb;
            surface.alpha = pixel_classes.material[k].a;
        }
    }
    return surface;
}

// Returns the fraction of the visible facets of the shaded class that are lit from wi. of_map is the openness towards wi.
float class_lit(const Surface surface, const vec3 wi, const vec4 of_map) {
    vec2 whitened = whitened_direction(wi, surface.whole_cholesky);
    float depth = class_depth(shaded_class.number, of_map);
    return class_lit_fraction(SHADOWING, shaded_class.correlation, shaded_class.depth, depth, surface.whitened, whitened);
}

float class_lit(const Surface surface, const vec3 wi) {
    return class_lit(surface, wi, classes_open(wi));
}

// Returns the fraction of the base's facets that are lit from wi, among those that are visible, on the shaded class.
float class_base_lit(const Surface surface, const vec3 wi) {
    vec2 m = surface.mean_slope;
    float variance = 0.5 * surface.alpha * surface.alpha;
    float area = visible_area(surface.wo, m, vec3(vec2(variance), 0.0));
    return round_lit_fraction(SHADOWING, surface.wo, max(meso_area(surface.wo, m), 0.0), area, wi, m, variance);
}

// Returns the result of horizon_hidden for the shaded class. In a loop that is unrolled, the directions are constants.
Hidden class_hidden(const vec2 m, const Horizon h) {
    Hidden hidden = Hidden(vec3(0.0), 0.0);
    [[unroll]] for (int k = 0; k < 2 * LEADR_HORIZON_AXES; ++k) {
        add_hidden(hidden, k, m, h);
    }
    return Hidden(hidden.weight / LEADR_HIDDEN_SUM, hidden.angle / LEADR_HIDDEN_SUM);
}

// Looks up the environment that all classes share.
void look_up_sky(const Surface surface) {
    vec3 up = normal_of_slope(surface.whole_mean);
    Frame frame = sky_frame(up, surface.wo);
    // Half the variance of a cone that holds the part of a direction. Wider lookups take light from the rings above and below.
    const float variance = 0.25 / float(LEADR_SKY_DIRECTIONS);
    [[unroll]] for (int i = 0; i < LEADR_SKY_DIRECTIONS; ++i) {
        vec3 wi = from_frame(frame, sky_direction(i));
        vec2 whitened = whitened_direction(wi, surface.whole_cholesky);
        float apart = decorrelation(surface.whitened, whitened, 1.0, 0.0, 0.0, true);
        pixel_sky.decorrelation[i] = SHADOWING == LEADR_SHADOWING_SMITH ? 1.0 : max(apart, LEADR_LEAST_SKY_DECORRELATION);
        pixel_sky.open[i] = classes_open(wi);
        pixel_sky.radiance[i] = lobe_radiance(surface, wi, variance);
        pixel_sky.direction[i] = wi;
    }
    [[unroll]] for (int i = 0; i < LEADR_GROUND_DIRECTIONS; ++i) {
        pixel_sky.down[i] = from_frame(frame, ground_direction(i));
        pixel_sky.ground[i] = lobe_radiance(surface, pixel_sky.down[i], 2.0 * variance);
    }
    vec3 down = from_frame(surface.frame, -up);
    pixel_sky.below = max(sh_irradiance(environment_sh(), down) + rest_irradiance(surface, down), 0.0) / LEADR_PI;
}

// Returns the diffuse radiance of the shaded class under the environment, per unit of albedo, and under a sky of radiance 1.
vec4 class_sky_light(const Surface surface) {
    NormalMoments visible = visible_diffuse_moments(surface.wo, surface.mean_slope, surface.slope_covariance, DIFFUSE_TERMS);
    vec4 lit = vec4(0.0), all = vec4(0.0);
    [[unroll]] for (int i = 0; i < LEADR_SKY_DIRECTIONS; ++i) {
        vec4 part = mean_cosine(visible, pixel_sky.direction[i]) * vec4(pixel_sky.radiance[i], 1.0);
        float depth = class_depth(shaded_class.number, pixel_sky.open[i]);
        vec2 f = vec2(pixel_sky.decorrelation[i], 1.0 - pixel_sky.decorrelation[i]);
        lit += class_lit_fraction(f, shaded_class.correlation, shaded_class.depth, depth) * part;
        all += part;
    }
    // The facets turn this part of their cosines to the ground. What is near the mesosurface counts as often as they face it.
    float tilted = clamp(0.5 - 0.5 * dot(visible.mean, normal_of_slope(surface.whole_mean)), 0.0, 0.9);
    vec4 ground = vec4(0.0);
    [[unroll]] for (int i = 0; i < LEADR_GROUND_DIRECTIONS; ++i) {
        const float wide = 0.5 * float(LEADR_SKY_DIRECTIONS) / float(LEADR_GROUND_DIRECTIONS);
        ground += wide * mean_cosine(visible, pixel_sky.down[i]) * vec4(pixel_sky.ground[i], 1.0);
    }
    float whole_ground = all.a * tilted / (1.0 - tilted);
    ground = ground * min(whole_ground / max(ground.a, 1e-9), 1.0) + max(whole_ground - ground.a, 0.0) * vec4(pixel_sky.below, 1.0);
    // The sums give only the part that is not hidden.
    vec3 rest = rest_irradiance(surface, visible.mean) * sh_rest_damping(visible.mean);
    vec3 whole = leadr_diffuse_environment(visible, surface.frame, environment_sh(), rest);
    return vec4(max(whole, 0.0), 1.0) * lit / max(all + ground, vec4(1e-9));
}

#endif
