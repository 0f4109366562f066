// The classes of facets under a pixel, each shaded as a surface of its own (leadr/masking/classes.glsl).
#ifndef LEADR_SHADE_CLASSES
#define LEADR_SHADE_CLASSES
#include "harmonics.glsl"
#include "lighting.glsl"
#include "leadr/visible/class_environment.glsl"

// The lights of the pixel, which all classes share, and the optical depths of the classes towards them.
Light pixel_lights[LIGHTS > 0 ? LIGHTS : 1];
vec4 pixel_lights_depths[LIGHTS > 0 ? LIGHTS : 1];
float pixel_lights_passed[LIGHTS > 0 ? LIGHTS : 1]; // the fraction that passes the shadow casters
// The diffuse radiance of each class under the environment, per unit of albedo, and under a sky of radiance 1.
vec4 pixel_sky[MOST_CLASSES];
// The class that is shaded.
struct ShadedClass {
    int number;
    int probes;        // number of probes of the specular environment
    float depth;       // optical depth towards the viewer
    vec2 base_area;    // projected area and visible area of a facet of the mean slope, with the roughness of the base
    vec3 correlation;  // of the openness towards different directions
};
ShadedClass shaded_class;
vec4 pixel_depth; // optical depths of the classes towards the viewer

#ifdef LEADR_CLASS_OPENNESS
// Whether the openness is that of the footprint, with what bumps larger than the footprint hide. Otherwise, the horizon has these bumps.
const bool LOCAL_OPENNESS = BY_CLASS && USES_HORIZON && !ATLAS;

vec4 class_openness_at(const vec2 at, const int layer) {
    return textureLod(class_openness, vec3(at, float(layer)), 0.0);
}
#else
const bool LOCAL_OPENNESS = false;

vec4 class_openness_at(const vec2 at, const int layer) {
    return vec4(1.0);
}
#endif

// Whether a horizon has the bumps that are larger than the footprint.
const bool HAS_HORIZON = USES_HORIZON && !LOCAL_OPENNESS;

// The part of the relief outside a footprint that hides nothing from the mean facet. A pixel shows open facets more often than others.
// Measured with scripts/external-truth.
const float SHOWN_OPEN = 0.5;

// Returns the openness of the classes towards w: of the facets in the footprint with LOCAL_OPENNESS, and of all facets otherwise.
vec4 classes_open(const vec3 w) {
    float up = w.z - dot(pixel_classes.offset, w.xy);
    int views = TRIPLANAR ? pixel_classes.views : 1;
    float inside = mix(1.0, pixel_classes.inside, SHOWN_OPEN);
    vec4 open = vec4(0.0);
    for (int i = 0; i < views; ++i) {
        vec2 q = vec2(dot(pixel_classes.s[i], w.xy), dot(pixel_classes.t[i], w.xy));
        vec2 at = 0.5 + 0.5 * q / (length(q) + max(up, 1e-4));
        vec4 of_map = class_openness_at(at, 0);
        if (LOCAL_OPENNESS) {
            [[unroll]] for (int k = 0; k < CLASSES; ++k) {
                of_map[k] = openness_inside(of_map[k], inside);
            }
            of_map = local_openness(of_map, class_openness_at(at, 1), pixel_classes.local[i]);
        }
        open += pixel_classes.weight[i] * of_map;
    }
    return up > 0.0 ? open : vec4(0.0);
}

// Returns the optical depths of the classes towards a direction.
vec4 depths_towards(const vec3 w) {
    vec4 open = classes_open(w);
    vec4 depths = vec4(0.0);
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        depths[k] = depth_inside(open[k], LOCAL_OPENNESS ? 1.0 : pixel_classes.inside);
    }
    return depths;
}

// Returns the optical depth of the shaded class towards a light.
float depth_towards(const vec3 w) {
    return depth_inside(classes_open(w)[shaded_class.number], LOCAL_OPENNESS ? 1.0 : pixel_classes.inside);
}

// Prepares the shading of the classes, and returns the share of each in the visible area.
vec4 classes_seen(inout Surface surface) {
    vec4 share = pixel_classes.share;
    if (!BY_CLASS) {
        return share;
    }
    surface.whole_cholesky = slope_cholesky(surface.slope_covariance);
    surface.whitened = whitened_direction(surface.wo, surface.whole_cholesky);
    pixel_depth = depths_towards(surface.wo);
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        share[k] *= visible_area(surface.wo, pixel_classes.mean[k], pixel_classes.covariance[k]) / (1.0 + pixel_depth[k]);
    }
    return share / max(dot(share, vec4(1.0)), 1e-9);
}

// Whether a surface is one of several classes that hide each other.
bool is_class(const Surface surface) {
    return BY_CLASS && !(COATED && surface.above);
}

// Returns the slope variance of the base along each axis.
float base_variance(const Surface surface) {
    return 0.5 * surface.alpha * surface.alpha;
}

// Returns the surface that consists of one class only. probes is the number of probes of the specular environment. Drivers would keep
// arrays with variable indices in memory.
Surface class_part(Surface surface, const int number, const int probes) {
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        if (k == number) {
            surface.mean_slope = pixel_classes.mean[k];
            surface.slope_covariance = pixel_classes.covariance[k];
            surface.albedo = pixel_classes.material[k].rgb;
            surface.alpha = pixel_classes.material[k].a;
        }
    }
    vec2 m = surface.mean_slope;
    vec2 base_area = vec2(max(meso_area(surface.wo, m), 0.0), visible_area(surface.wo, m, vec3(vec2(base_variance(surface)), 0.0)));
    shaded_class = ShadedClass(number, probes, pixel_depth[number], base_area, pixel_classes.correlation[number].xyz);
    return surface;
}

// Returns the fraction of the visible facets of the shaded class that are lit from wi. depth is the optical depth towards wi.
float class_lit(const Surface surface, const vec3 wi, const float depth) {
    vec2 apart = azimuths_apart(SHADOWING, surface.whitened, whitened_direction(wi, surface.whole_cholesky));
    return class_lit_fraction(SHADOWING, apart, shaded_class.correlation, shaded_class.depth, depth);
}

// Returns the fraction of a light from wi that reaches the shaded class, relative to the fraction that passed the shadow casters. depths is
// the result of depths_towards. The bumps larger than the footprint are among the casters, and also lower the local openness, so the smaller
// fraction counts.
float class_lit_by(const Surface surface, const vec3 wi, const vec4 depths, const float passed) {
    float lit = class_lit(surface, wi, depths[shaded_class.number]);
    return LOCAL_OPENNESS ? mix(min(lit / max(passed, 1e-3), 1.0), lit, pixel_classes.inside) : lit;
}

float class_lit(const Surface surface, const vec3 wi) {
    return class_lit(surface, wi, depth_towards(wi));
}

// Returns the fraction of the base's facets that are lit from wi, among those that are visible, on the shaded class.
float class_base_lit(const Surface surface, const vec3 wi) {
    return round_lit_fraction(SHADOWING, surface.wo, shaded_class.base_area.x, shaded_class.base_area.y, wi, surface.mean_slope,
                              base_variance(surface));
}

// Computes pixel_sky. seen has the shares of the classes in the visible area.
void light_by_sky(const Surface surface, const vec4 seen) {
    vec3 up = normal_of_slope(surface.whole_mean);
    Frame frame = sky_frame(up, surface.wo);
    // Half the variance of a cone that holds the part of a direction. Wider lookups take light from the rings above and below.
    const float variance = 0.018;
    NormalMoments visible[CLASSES];
    NormalMoments whole = NormalMoments(vec3(0.0), vec3(0.0), vec3(0.0));
    vec4 lit[CLASSES];
    float cosines[CLASSES];
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        visible[k] = visible_diffuse_moments(surface.wo, pixel_classes.mean[k], pixel_classes.covariance[k], DIFFUSE_TERMS);
        whole.mean += seen[k] * visible[k].mean;
        whole.diag += seen[k] * visible[k].diag;
        whole.off += seen[k] * visible[k].off;
        lit[k] = vec4(0.0);
        cosines[k] = 0.0;
    }
    vec3 all = vec3(0.0);
    for (int i = 0; i < LEADR_SKY_DIRECTIONS; ++i) {
        vec3 wi = from_frame(frame, sky_direction(i));
        vec2 apart = azimuths_apart(SHADOWING, surface.whitened, whitened_direction(wi, surface.whole_cholesky));
        vec4 depths = depths_towards(wi);
        vec4 light = vec4(lobe_radiance(surface, wi, variance), 1.0);
        float weight = sky_weight(i);
        [[unroll]] for (int k = 0; k < CLASSES; ++k) {
            float cosine = weight * mean_cosine(visible[k], wi);
            lit[k] += cosine * class_lit_fraction(apart, pixel_classes.correlation[k].xyz, pixel_depth[k], depths[k]) * light;
            cosines[k] += cosine;
            all += seen[k] * cosine * light.rgb;
        }
    }
    vec4 ground = vec4(0.0);
    for (int i = 0; i < LEADR_GROUND_DIRECTIONS; ++i) {
        vec3 wi = from_frame(frame, ground_direction(i));
        float cosine = 0.0;
        [[unroll]] for (int k = 0; k < CLASSES; ++k) {
            cosine += seen[k] * mean_cosine(visible[k], wi);
        }
        ground += ground_weight(i) * cosine * vec4(lobe_radiance(surface, wi, variance), 1.0);
    }
    // The facets turn the part `tilted` of their cosines to the ground.
    float whole_ground = 0.0;
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        float tilted = clamp(0.5 - 0.5 * dot(visible[k].mean, up), 0.0, 0.9);
        whole_ground += seen[k] * cosines[k] * tilted / (1.0 - tilted);
        pixel_sky[k].a = lit[k].a * (1.0 - tilted) / max(cosines[k], 1e-9);
    }
    vec3 down = from_frame(surface.frame, -up);
    vec3 below = max(sh_irradiance(environment_sh(), down) + rest_irradiance(surface, down), 0.0) / LEADR_PI;
    all += ground.rgb * min(whole_ground / max(ground.a, 1e-9), 1.0) + max(whole_ground - ground.a, 0.0) * below;
    // The sums give only the part that is not hidden.
    vec3 rest = rest_irradiance(surface, whole.mean) * sh_rest_damping(whole.mean);
    vec3 factor = max(leadr_diffuse_environment(whole, surface.frame, environment_sh(), rest), 0.0) / max(all, vec3(1e-9));
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        pixel_sky[k].rgb = lit[k].rgb * factor;
    }
}

#endif
