// Filters the classes of facets under a pixel. All quantities are weighted by the class, so they are linear
// (crates/leadr-maps/src/class_map).
#ifndef LEADR_FILTER_CLASSES
#define LEADR_FILTER_CLASSES
#include "leadr/slopes/rotation.glsl"

// For each class, the six values w, w x, w y, w xx, w yy, w xy, packed in layers of four, and then a layer with the amounts of the local
// openness, except in atlases. w is the weight of the class, and x and y are the slope about the centre of the class.
layout(set = 2) uniform sampler2DArray class_moments;
// For each class, its weight times (colour, alpha^2). One more layer has the weights. The finest levels of large maps are left out.
layout(set = 2) uniform sampler2DArray class_colors;
// The coarse levels of both for an atlas (atlas.glsl).
layout(set = 2) uniform sampler2DArray coarse_class_moments;
layout(set = 2) uniform sampler2DArray coarse_class_colors;
// Layer 0: the openness of each class (leadr_maps::derive::Openness); layer 1: the components of the local openness.
layout(set = 2) uniform sampler2DArray class_openness;
layout(constant_id = 68) const bool CLASS_COLORS = false; // whether colours or roughnesses differ between classes

// The smallest weight of a class that is shaded. The weights of the other classes go to the remaining ones.
const float LEAST_CLASS = 1.0 / 256.0;

const int CLASS_LAYERS = (3 * CLASSES + 1) / 2 + (ATLAS ? 0 : 1);
const int MOST_CLASS_LAYERS = 7;

struct ClassMeans {
    vec3 first[MOST_CLASSES];  // w, w x, w y
    vec3 second[MOST_CLASSES]; // w xx, w yy, w xy
    vec4 color[MOST_CLASSES];
    vec4 color_weight;
    vec4 local;
};

ClassMeans no_class_means() {
    ClassMeans means;
    for (int k = 0; k < MOST_CLASSES; ++k) {
        means.first[k] = means.second[k] = vec3(0.0);
        means.color[k] = vec4(0.0);
    }
    means.color_weight = vec4(0.0);
    means.local = vec4(0.0);
    return means;
}

// Returns values i to i + 2 in the layers. The index must be constant.
vec3 class_values(const vec4 layers[MOST_CLASS_LAYERS], const int i) {
    return vec3(layers[i / 4][i % 4], layers[(i + 1) / 4][(i + 1) % 4], layers[(i + 2) / 4][(i + 2) % 4]);
}

void add_class_moments(inout ClassMeans means, const float weight, const vec2 texcoord, const float lod) {
    vec4 layers[MOST_CLASS_LAYERS];
    [[unroll]] for (int i = 0; i < CLASS_LAYERS; ++i) {
        layers[i] = textureLod(class_moments, vec3(texcoord, float(i)), lod);
    }
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        means.first[k] += weight * class_values(layers, 6 * k);
        means.second[k] += weight * class_values(layers, 6 * k + 3);
    }
    if (USES_HORIZON) {
        means.local += weight * layers[CLASS_LAYERS - 1];
    }
}

void add_class_colors(inout ClassMeans means, const float weight, const vec2 texcoord, const float lod) {
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        means.color[k] += weight * textureLod(class_colors, vec3(texcoord, float(k)), lod);
    }
    means.color_weight += weight * textureLod(class_colors, vec3(texcoord, float(CLASSES)), lod);
}

// Returns the finest level that has classes, for maps of this size in texels.
float first_class_level(const vec2 size) {
    return log2(size.x / float(textureSize(class_moments, 0).x));
}

// Returns the rotation between the slopes of two patches of an atlas, as rise over run along their sides. gradient converts gradients by
// texture coordinate, and lengths are those of the tangents of the patch to which it converts.
mat2 slope_rotation(const mat2 gradient, const vec2 lengths) {
    vec2 s = gradient[0] / lengths, t = gradient[1] / lengths;
    return mat2(s * inversesqrt(max(dot(s, s), 1e-30)), t * inversesqrt(max(dot(t, t), 1e-30)));
}

// Adds the classes at a point of an atlas, whose slopes are about zero and in one unit, along aligned directions. index is the patch of the
// pixel, and size is that of the atlas in texels. Class maps may start at a coarser level.
void add_atlas_classes(inout ClassMeans means, const float weight, const uint index, const AtlasPoint point, const Levels levels,
                       const vec2 size, const vec2 lengths) {
    vec2 at = (tile_start(point.index) + point.at * tile_inner()) / size;
    float mip = levels.mip - first_class_level(size);
    mat2 rotation = aligned_slopes(index) * slope_rotation(point.gradient, lengths) * transpose(aligned_slopes(point.index));
    vec4 layers[MOST_CLASS_LAYERS];
    [[unroll]] for (int i = 0; i < CLASS_LAYERS; ++i) {
        layers[i] = layer_mix(class_moments, coarse_class_moments, i, at, mip, point, levels);
    }
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        vec3 first = class_values(layers, 6 * k);
        means.first[k] += weight * vec3(first.x, rotation * first.yz);
        means.second[k] += weight * map_second_moments(rotation, class_values(layers, 6 * k + 3));
    }
    if (CLASS_COLORS) {
        mip = levels.mip - log2(size.x / float(textureSize(class_colors, 0).x));
        [[unroll]] for (int k = 0; k < CLASSES; ++k) {
            means.color[k] += weight * layer_mix(class_colors, coarse_class_colors, k, at, mip, point, levels);
        }
        means.color_weight += weight * layer_mix(class_colors, coarse_class_colors, CLASSES, at, mip, point, levels);
    }
}

// Returns the moments of the slopes of all classes together: the mean, and the second moments xx, yy, xy.
void joined_class_moments(const ClassMeans means, out vec2 mean, out vec3 second) {
    mean = vec2(0.0);
    second = vec3(0.0);
    float whole = 0.0;
    vec3 unit = OBJECT.class_unit.xyz;
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        float w = means.first[k].x;
        vec2 centre = OBJECT.class_centers[k].xy, about = unit.xy * means.first[k].yz;
        mean += w * centre + about;
        second += w * vec3(centre * centre, centre.x * centre.y)
                + vec3(2.0 * centre * about, centre.x * about.y + centre.y * about.x)
                + vec3(unit.xy * unit.xy, unit.x * unit.y) * means.second[k];
        whole += w;
    }
    mean /= max(whole, 1e-6);
    second /= max(whole, 1e-6);
}

// Sets the shares of the classes of a smooth surface, which are those of its material.
void classes_of_material(inout ClassMeans means) {
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        means.first[k].x = means.color_weight[k];
    }
}

// Adds a projection of the openness. linear converts gradients of the map to slopes.
void add_openness_view(inout FacetClasses classes, const mat2 linear, const float scale, const float weight) {
    classes.s[classes.views] = abs(scale) * OBJECT.class_unit.x * linear[0];
    classes.t[classes.views] = abs(scale) * OBJECT.class_unit.y * linear[1];
    classes.weight[classes.views] = weight;
    classes.views += 1;
}

// The classes of a footprint.
struct ClassParts {
    SlopePart part[MOST_CLASSES]; // mean and covariance of the gradients of each class; the area is its weight
    float inside;                 // fraction of the relief's slope variance that the footprint contains
    vec4 local[MOST_VIEWS];       // local openness in each projection
};

// Returns the mean and the covariance of the gradients of a class.
SlopePart class_part_of(const ClassMeans means, const int k) {
    vec2 unit = OBJECT.class_unit.xy;
    float w = max(means.first[k].x, 1e-12);
    vec2 about = means.first[k].yz / w;
    vec3 variance = vec3(unit * unit, unit.x * unit.y) * covariance_from_moments(about, means.second[k] / w);
    return SlopePart(OBJECT.class_centers[k].xy + unit * about, variance, means.first[k].x);
}

// Returns the fraction of the relief's slope variance in a footprint. gradient_variance is the variance of the gradients, in units of the map.
float variance_inside(const vec2 gradient_variance) {
    vec2 in_units = gradient_variance / (OBJECT.class_unit.xy * OBJECT.class_unit.xy);
    return clamp((in_units.x + in_units.y) / max(OBJECT.class_unit.w, 1e-6), 0.0, 1.0);
}

// Returns the classes of a footprint in one map.
ClassParts class_parts(const ClassMeans means, const vec2 gradient_variance) {
    ClassParts parts;
    for (int k = 0; k < MOST_CLASSES; ++k) {
        parts.part[k] = class_part_of(means, k);
    }
    parts.inside = variance_inside(gradient_variance);
    for (int i = 0; i < MOST_VIEWS; ++i) {
        parts.local[i] = means.local;
    }
    return parts;
}

ClassParts no_class_parts() {
    ClassParts parts;
    for (int k = 0; k < MOST_CLASSES; ++k) {
        parts.part[k] = SlopePart(vec2(0.0), vec3(0.0), 0.0);
    }
    parts.inside = 0.0;
    for (int i = 0; i < MOST_VIEWS; ++i) {
        parts.local[i] = vec4(0.0);
    }
    return parts;
}

// Adds the classes of one of several uncorrelated reliefs, whose covariances add. mean is the mean gradient of this relief, gradient
// converts its gradients to those of the sum, and weight is its factor on the heights. view counts the reliefs. A class keeps its deviation from the mean.
void add_class_parts(inout ClassParts parts, const int view, const ClassMeans means, const vec2 mean, const vec2 gradient_variance, const mat2 gradient,
                     const float weight) {
    float share = weight * weight;
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        SlopePart part = class_part_of(means, k);
        parts.part[k] = join_slopes(parts.part[k], SlopePart(gradient * (part.mean - mean), map_second_moments(gradient, part.covariance),
                                                             share * part.area));
    }
    parts.inside += share * variance_inside(gradient_variance);
    parts.local[view] = means.local;
}

// Returns the classes of a footprint. scale is the height scale, map converts gradients to slopes, and tint is a factor on the colours and
// on alpha. material is the mean material, before this factor if colours differ, and after it otherwise. slope and covariance come from
// other sources than the map, and every class has them in addition. The openness has one view, along the coordinates of the map.
FacetClasses facet_classes(const ClassParts parts, const ClassMeans means, const float scale, const SlopeMap map, const vec2 slope,
                           const vec3 covariance, const vec4 material, const vec4 tint) {
    FacetClasses classes;
    classes.share = vec4(0.0);
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        SlopePart part = parts.part[k];
        classes.share[k] = part.area > LEAST_CLASS ? part.area : 0.0;
        classes.mean[k] = map_mean_slope(map, scale * part.mean) + slope;
        classes.covariance[k] = map_covariance(map, scale_height(part.covariance, scale)) + covariance;
        classes.material[k] = material;
        if (CLASS_COLORS) {
            // A class that the footprint in the colours does not contain has the mean material.
            const float least = LEAST_CLASS * LEAST_CLASS;
            vec4 color = (max(means.color[k], 0.0) + least * material) / (max(means.color_weight[k], 0.0) + least);
            classes.material[k] = tint * vec4(color.rgb, sqrt(color.a));
        }
    }
    classes.share /= max(dot(classes.share, vec4(1.0)), 1e-6);
    classes.views = 0;
    add_openness_view(classes, mat2(map.linear_s, map.linear_t), scale, 1.0);
    classes.offset = map.offset;
    classes.inside = parts.inside;
    classes.local = parts.local;
    for (int k = 0; k < MOST_CLASSES; ++k) {
        classes.correlation[k] = OBJECT.class_correlation[k];
    }
    classes.sky_depth = (USES_HORIZON && !ATLAS ? 1.0 : classes.inside) * OBJECT.class_sky_depth;
    return classes;
}

#endif
