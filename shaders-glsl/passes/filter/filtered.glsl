// Filters the maps of one object under each of its pixels (LEADR section 4.1 and eq. 12).
#ifndef LEADR_FILTER_FILTERED
#define LEADR_FILTER_FILTERED
#include "../geometry/object.glsl"
#include "../geometry/footprint.glsl"
#include "../geometry/rest_triangle.glsl"
#include "../geometry/tile.glsl"
#include "../tiling.glsl"
#include "../gbuffer.glsl"
#include "../bases.glsl"
#include "../technique.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"
#include "leadr/slopes/geometric_antialiasing.glsl"
#include "leadr/slopes/map.glsl"
#include "atlas.glsl"
layout(constant_id = 41) const bool ATLAS = false; // whether the maps are atlases with one tile per patch
#include "classes.glsl"

layout(constant_id = 40) const int MAX_TAPS = 8; // largest number of taps along the long axis of the pixel's footprint
layout(constant_id = 66) const int TAP_ROWS = 1; // number of rows of taps across the footprint, for the slope and material maps
// The maps of the object. The maps are selected by constants, because drivers without divergent branches (lavapipe) run both sides of an
// `if`.
layout(constant_id = 42) const bool DISPLACED = true;
layout(constant_id = 43) const bool COLORED = true;
layout(constant_id = 44) const bool HORIZON = true;
layout(constant_id = 45) const bool FLAT = false;  // tangents by texture coordinate are constant
layout(constant_id = 51) const bool TRIANGLES = false; // patches are flat triangles
layout(constant_id = 55) const bool RISE_OVER_RUN = false; // maps hold slopes as rise over run, not per texture coordinate
layout(constant_id = 46) const bool PLAIN = false; // all vertices have the same colour and accessibility
layout(constant_id = 47) const bool RELIEF_DRAWN = true; // the geometry is displaced by the full height map
layout(constant_id = 50) const bool REFLECTS_BY_MAP = false; // a map gives the reflectance at normal incidence
layout(constant_id = 52) const bool EMITS = false;    // the material emits light
layout(constant_id = 53) const bool OCCLUDED = false; // the material has an occlusion map
layout(constant_id = 54) const bool CHARTED = false;  // the material has its own texture coordinates
layout(constant_id = 72) const bool COAT_MAP = false; // a map gives the clear coat
layout(constant_id = 48) const bool EDGE_SAMPLES = true; // the pixels may be edge samples
layout(constant_id = 70) const bool JOINS_EDGES = false; // edge samples are joined in the G-buffer
layout(constant_id = 64) const bool BY_EXAMPLE = false; // maps are tiled without visible repeats; flat objects only
layout(constant_id = 65) const bool GROUND = false; // open ground with drifts and paths; flat objects only
#include "drifts.glsl"
#include "macrosurface.glsl"

uniform usampler2D visible_surface;   // output of the geometry pass for pixels
uniform usampler2D visible_footprint; // output of the geometry pass for edge samples
layout(set = 2) uniform sampler2D height_map;
layout(set = 2) uniform sampler2D moments_a; // E[hs], E[ht], E[hs^2], E[ht^2], per unit texture coordinate
layout(set = 2) uniform sampler2D moments_b; // E[hs ht]
layout(set = 2) uniform sampler2D color_map;   // rgb: albedo; a: square root of the roughness alpha
layout(set = 2) uniform sampler2D f0_map;      // rgb reflectance at normal incidence
layout(set = 2, std430) readonly buffer Charts { TriangleCharts charts[]; };
layout(set = 2) uniform sampler2D emission_map;
layout(set = 2) uniform sampler2D occlusion_map; // x: accessibility; with CONES, a cone in the frame of the texture with y up
uniform sampler2D visible_depth;
// Lean, and standard deviations of the spread (leadr/visible/horizon.glsl). With CONES, there is no horizon, and an atlas has the coarse
// levels of its cones here.
layout(set = 2) uniform sampler2D horizon_a;
layout(set = 2) uniform sampler2D horizon_b; // correlation of the spread

struct Footprint {
    vec2 step;    // step between taps along the footprint, in texels
    vec2 row;     // step between rows of taps, across the footprint
    int rows;
    int taps;     // number of taps in all rows
    float lod;    // level of detail of the taps
    float level;  // level of detail for a single row of taps as wide as the footprint's short axis
    float across; // level of detail whose texels are as wide as the footprint's short axis
    float widest; // level of detail whose texels are as wide as the footprint's long axis
};

const Footprint POINT_FOOTPRINT = Footprint(vec2(0.0), vec2(0.0), 1, 1, 0.0, 0.0, 0.0, 0.0);

// The variance of a trilinear tap, divided by the variance of a pixel as wide as its texels. A texel mean has a variance of 1/12, and
// interpolation adds 1/6; a pixel has 1/12, so the ratio is 3. A slightly lower value is more accurate in measurements, because it widens
// taps that do not overlap.
const float TAP_VARIANCE = 2.5;
// The variance of a map's own reconstruction, before the pixel filter. For images and averaged values, it is the variance of one tap in the
// finest level. Slopes are those of flat triangles, and have no variance.
const float OF_IMAGE = TAP_VARIANCE, OF_SLOPES = 0.0;
// The number of additional taps for each footprint width by which the footprint is longer than wide.
const float OVERLAP = 1.3;

// Returns the squared distance between `taps` taps in a line that has the given second moment. Each tap has the shape of a pixel. The
// function also returns the squared width of a tap, which is at least `narrowest`.
float taps_apart(const float squared, const float taps, const float narrowest, out float width_squared) {
    width_squared = max(squared / (taps * taps), narrowest);
    return max(squared - width_squared, 0.0) / max(taps * taps - 1.0, 1.0);
}

// Moments are linear, so a few isotropic taps along the long axis replace the elliptical footprint of a pixel. The widths and distances of
// the taps preserve the second moment of the footprint, so nothing jumps when the number of taps changes. dx and dy are the derivatives in
// texels of the map. reach is the largest distance of a tap, in texels. own is the second moment of the map's reconstruction.
Footprint elliptical_footprint(vec2 dx, vec2 dy, const float reach, float own, int rows) {
    // All lengths grow by the same factor, so every level shifts by the bias, and the taps stay the same.
    float wider = VIEW.widening, narrowest = TAP_VARIANCE * wider * wider;
    dx *= wider;
    dy *= wider;
    own *= wider * wider;
    float xx = dot(dx, dx), yy = dot(dy, dy);
    vec2 along = xx > yy ? dx : dy;
    float major_squared = max(xx, yy);
    float major = sqrt(major_squared);
    // The width of the footprint across its long axis is its area divided by its length.
    float minor = abs(dx.x * dy.y - dx.y * dy.x) / max(major, 1e-20);
    float row_width_squared, width_squared;
    float row_squared = taps_apart(minor * minor + own, float(rows), narrowest, row_width_squared);
    Footprint footprint;
    footprint.rows = rows;
    // The number is clamped as a float, and the loops over the taps use `for`. With an integer bound, lavapipe unrolls the loop and runs
    // every tap. A `do` loop gives wrong pixels on lavapipe.
    float taps = clamp(ceil(float(rows) * (1.0 + OVERLAP * (major / max(minor, wider) - 1.0))), 1.0, float(MAX_TAPS * rows));
    footprint.taps = int(taps) * rows;
    float step_squared = taps_apart(major_squared + own, taps, row_width_squared, width_squared);
    float longest = 2.0 * reach / max(taps - 1.0, 1.0);
    if (step_squared > longest * longest) {
        // Beyond the reach of the taps, wider taps cover the remaining length.
        step_squared = longest * longest;
        width_squared = major_squared + own - step_squared * max(taps * taps - 1.0, 1.0);
    }
    along /= max(major, 1e-20);
    footprint.step = along * sqrt(step_squared);
    footprint.row = vec2(-along.y, along.x) * min(sqrt(row_squared), 2.0 * reach / max(float(rows) - 1.0, 1.0));
    footprint.lod = max(0.5 * log2(width_squared / TAP_VARIANCE), 0.0);
    footprint.level = max(0.5 * log2(max(width_squared, minor * minor + own) / TAP_VARIANCE), 0.0);
    footprint.across = max(0.5 * log2(max(width_squared, minor * minor)), 0.0);
    footprint.widest = max(0.5 * log2(major_squared), 0.0);
    return footprint;
}

// Returns the offset of a tap from the centre of the footprint, in texels.
vec2 tap(const Footprint footprint, const int i) {
    if (footprint.rows == 1) {
        return footprint.step * (float(i) + 0.5 - 0.5 * float(footprint.taps));
    }
    float in_row = float(footprint.taps / footprint.rows), row = floor((float(i) + 0.5) / in_row);
    return footprint.step * (float(i) - row * in_row + 0.5 - 0.5 * in_row)
         + footprint.row * (row + 0.5 - 0.5 * float(footprint.rows));
}

Footprint footprint_over(const vec2 dx, const vec2 dy, const float reach, const float own, const int rows) {
    if (FINEST_LEVEL) {
        return POINT_FOOTPRINT;
    }
    Footprint footprint = elliptical_footprint(dx, dy, reach, own, rows);
    if (ATLAS) {
        // Samples that patches share cover a larger area than texels do.
        float wider = footprint.lod + 0.5 * log2(TAP_VARIANCE);
        float lod = mix(footprint.lod, wider, clamp(0.5 * (wider - float(SOURCE_LEVEL)) + 0.5, 0.0, 1.0));
        footprint.level += lod - footprint.lod;
        footprint.lod = lod;
    }
    return footprint;
}

// The mean values of the maps over a footprint.
struct Means {
    vec2 mean;   // E[hs], E[ht]
    vec3 second; // E[hs^2], E[ht^2], E[hs ht]
    vec4 color;  // rgb: albedo; a: alpha^2
    vec3 f0;
    vec4 light;  // rgb: emission; a: accessibility
    vec4 cone;   // xyz: direction, in the world; w: accessibility
};

const Means NO_MEANS = Means(vec2(0.0), vec3(0.0), vec4(0.0), vec3(0.0), vec4(0.0, 0.0, 0.0, 1.0), NO_CONE);

// Converts a colour texel to linear quantities. Roughness is averaged as a variance (LEADR section 4.1).
vec4 linear_color(const vec4 texel) {
    float alpha = texel.a * texel.a;
    return vec4(texel.rgb, alpha * alpha);
}

// Returns the emission and the accessibility.
vec4 filter_atlas_light(const Footprint footprint, const uint index, const vec2 at, const Levels levels) {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < footprint.taps; ++i) {
        AtlasPoint point = point_across_borders(index, at + tap(footprint, i) / tile_inner());
        vec3 emission = EMITS ? level_mix(emission_map, coarse_light, point, levels).rgb : vec3(0.0);
        // The coarse levels and the tiles store the accessibility in different images.
        float accessibility =
            OCCLUDED && !CONES ? fine_part(occlusion_map, point, levels).x + coarse_part(coarse_light, point, levels).a : 1.0;
        sum += vec4(emission, accessibility);
    }
    return sum / float(footprint.taps);
}

// Returns the mean cone of an atlas, in the frame of the patch at the middle of the footprint.
vec4 filter_atlas_cone(const Footprint footprint, const uint index, const vec2 at) {
    Levels levels = levels_at(footprint.lod);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < footprint.taps; ++i) {
        AtlasPoint point = point_across_borders(index, at + tap(footprint, i) / tile_inner());
        vec4 cone = level_mix(occlusion_map, horizon_a, point, levels);
        // The y axis of cones is -t, so their rotation is the inverse one.
        sum += vec4(cone.xy * nearest_rotation(point.gradient), cone.zw);
    }
    return sum / float(footprint.taps);
}

// Returns the direction of a cone in the world. by_uv has the derivatives of the map's coordinates by position. The frame of the cone is
// the orthonormal frame nearest to the directions of s and -t. Seen from behind, bumps are pits, and the cone is mirrored like the normals.
vec3 cone_on_surface(const Macrosurface surface, const mat2 by_uv, const bool behind, const vec3 cone) {
    vec3 along = vec3(0.0);
    if (abs(determinant(by_uv)) > 1e-20) {
        mat2x3 tangents = surface.by_uv * inverse(by_uv);
        vec3 s = tangents[0] - surface.normal * dot(surface.normal, tangents[0]);
        vec3 t = tangents[1] - surface.normal * dot(surface.normal, tangents[1]);
        s *= inversesqrt(max(dot(s, s), 1e-30));
        t *= inversesqrt(max(dot(t, t), 1e-30));
        // The bisectors of two unit vectors are orthogonal.
        vec3 between = s + t, across = s - t;
        between *= inversesqrt(max(2.0 * dot(between, between), 1e-30));
        across *= inversesqrt(max(2.0 * dot(across, across), 1e-30));
        along = cone.x * (between + across) - cone.y * (between - across);
    }
    return (behind ? -along : along) + cone.z * surface.normal;
}

// Returns the footprint in repeating textures, which have no tile borders.
Footprint detail_footprint(const vec2 dx, const vec2 dy, const float own) {
    return FINEST_LEVEL ? POINT_FOOTPRINT : elliptical_footprint(clamp(dx, -6e4, 6e4), clamp(dy, -6e4, 6e4), 1e9, own, 1);
}
#include "height_scale.glsl"
#include "detail.glsl"

// Filters an atlas and its classes. lengths are those of the tangents by texture coordinate.
Means filter_atlas(const Footprint footprint, const uint index, const vec2 at, const vec2 lengths, inout ClassMeans classes) {
    Levels levels = levels_at(footprint.lod);
    Means sum = NO_MEANS;
    for (int i = 0; i < footprint.taps; ++i) {
        AtlasPoint point = point_across_borders(index, at + tap(footprint, i) / tile_inner());
        if (USES_SLOPES && DISPLACED) {
            vec4 a = level_mix(moments_a, coarse_a, point, levels);
            sum.mean += point.gradient * a.xy;
            if (USES_COVARIANCE) {
                float b = level_mix(moments_b, coarse_b, point, levels).x;
                sum.second += map_second_moments(point.gradient, vec3(a.zw, b));
            }
        }
        if (COLORED) {
            sum.color += linear_color(level_mix(color_map, coarse_color, point, levels));
        }
        if (REFLECTS_BY_MAP) {
            sum.f0 += level_mix(f0_map, coarse_f0, point, levels).rgb;
        }
        if (CLASSES > 1) {
            add_atlas_classes(classes, 1.0 / float(footprint.taps), index, point, levels,
                              vec2(textureSize(moments_a, 0)), lengths);
        }
    }
    float weight = 1.0 / float(footprint.taps);
    vec4 light = EMITS || (OCCLUDED && !CONES) ? filter_atlas_light(footprint, index, at, levels) : sum.light;
    return Means(sum.mean * weight, sum.second * weight, sum.color * weight, sum.f0 * weight, light, NO_CONE);
}

// A texture coordinate, and its derivatives by x and y of the image.
struct Chart {
    vec2 at;
    mat2 across;
};

Footprint footprint_in(const Chart chart, sampler2D map, const float own, const int rows) {
    vec2 size = vec2(textureSize(map, 0));
    return footprint_over(clamp(chart.across[0] * size, -6e4, 6e4), clamp(chart.across[1] * size, -6e4, 6e4), 1e9, own, rows);
}

// Returns the means of the map of a clear coat over a footprint. The first image has weight, alpha^2, and the mean slope as rise over run; the
// second has E[x^2], E[y^2] and E[xy]. An object without an atlas has them in the images of the coarse levels.
void filter_coat(const Chart chart, out vec4 first, out vec3 second) {
    vec2 size = vec2(textureSize(coarse_light, 0));
    Footprint footprint = footprint_over(clamp(chart.across[0] * size, -6e4, 6e4), clamp(chart.across[1] * size, -6e4, 6e4), 1e9, OF_IMAGE, 1);
    first = vec4(0.0);
    second = vec3(0.0);
    for (int i = 0; i < footprint.taps; ++i) {
        vec2 at = chart.at + tap(footprint, i) / size;
        first += textureLod(coarse_light, at, footprint.lod);
        second += textureLod(coarse_color, at, footprint.lod).xyz;
    }
    first /= float(footprint.taps);
    second /= float(footprint.taps);
}

// Returns the offset of an object in the lattice of tiling variants, in repeats.
vec2 tiling_shift() {
    return OBJECT.shift;
}

// Adds the moments of a relief tiled by example. passing is the slope described at tiled_height. The slope is so small that it is evaluated
// only at the centre of the footprint.
void filter_tiled_moments(Footprint footprint, OffsetVariants variants, const vec2 texcoord, const vec2 passing, inout Means means) {
    vec2 mean = vec2(0.0);
    vec3 second = vec3(0.0);
    float part = FINEST_LEVEL && footprint.lod <= 0.0 ? 1.0 : tiling_part(variants, moments_a, footprint.lod);
    variants = merged_at(variants, footprint.level);
    vec2 per_texel = 1.0 / vec2(textureSize(moments_a, 0)), middle = texcoord + tiling_shift();
    SlopeMoments blend = SlopeMoments(passing, vec3(0.0));
    for (TapVariant now = first_variant(variants); now.tap < footprint.taps; next_variant(now, variants)) {
        vec2 at = middle + now.from + tap(footprint, now.tap) * per_texel;
        vec4 a = textureLod(moments_a, at, footprint.lod);
        float b = USES_COVARIANCE ? textureLod(moments_b, at, footprint.lod).x : 0.0;
        blend = add_variant(blend, SlopeMoments(a.xy, vec3(a.zw, b)), now.weight, part);
        // The square of a tap's mean slope is added after all variants of the tap.
        float whole = now.last ? 1.0 : 0.0;
        mean += whole * blend.first;
        second += whole * (blend.second + vec3(blend.first * blend.first, blend.first.x * blend.first.y));
        blend = SlopeMoments(mix(blend.first, passing, whole), blend.second * (1.0 - whole));
    }
    float weight = 1.0 / float(footprint.taps);
    means.mean = mean * weight;
    means.second = second * weight;
}

void filter_moments(const Footprint footprint, const vec2 texcoord, inout Means means) {
    vec4 a = vec4(0.0);
    float b = 0.0;
    for (int i = 0; i < footprint.taps; ++i) {
        vec2 at = texcoord + tap(footprint, i) / vec2(textureSize(moments_a, 0));
        a += textureLod(moments_a, at, footprint.lod);
        if (USES_COVARIANCE) {
            b += textureLod(moments_b, at, footprint.lod).x;
        }
    }
    float weight = 1.0 / float(footprint.taps);
    means.mean = a.xy * weight;
    means.second = vec3(a.zw, b) * weight;
}

// Filters the classes of the relief, and derives from them the moments of all facets.
void filter_classes(const Footprint footprint, const vec2 texcoord, inout ClassMeans classes, inout Means means) {
    float weight = 1.0 / float(footprint.taps);
    vec2 size = vec2(textureSize(class_moments, 0).xy);
    for (int i = 0; i < footprint.taps; ++i) {
        add_class_moments(classes, weight, texcoord + tap(footprint, i) / size, footprint.lod);
    }
    joined_class_moments(classes, means.mean, means.second);
}

// Filters the classes of a relief that is tiled by example. The variants are mixed by the squares of their weights.
void filter_tiled_classes(const Footprint footprint, OffsetVariants variants, const vec2 texcoord, inout ClassMeans classes) {
    variants = merged_at(variants, footprint.level);
    float weight = 1.0 / float(footprint.taps);
    vec2 per_texel = 1.0 / vec2(textureSize(class_moments, 0).xy), middle = texcoord + tiling_shift();
    for (TapVariant now = first_variant(variants); now.tap < footprint.taps; next_variant(now, variants)) {
        vec2 at = middle + now.from + tap(footprint, now.tap) * per_texel;
        add_class_moments(classes, weight * now.weight * now.weight, at, footprint.lod);
    }
}

// Filters the colours of the classes. footprint is in texels of the colour map.
void filter_class_colors(const Footprint footprint, OffsetVariants variants, const vec2 texcoord, inout ClassMeans classes) {
    float weight = 1.0 / float(footprint.taps);
    vec2 per_texel = 1.0 / vec2(textureSize(color_map, 0));
    float lod = footprint.lod - log2(float(textureSize(color_map, 0).x) / float(textureSize(class_colors, 0).x));
    if (BY_EXAMPLE) {
        variants = merged_at(variants, footprint.level);
        for (TapVariant now = first_variant(variants); now.tap < footprint.taps; next_variant(now, variants)) {
            vec2 at = texcoord + tiling_shift() + now.from + tap(footprint, now.tap) * per_texel;
            add_class_colors(classes, weight * now.weight * now.weight, at, lod);
        }
        return;
    }
    for (int i = 0; i < footprint.taps; ++i) {
        add_class_colors(classes, weight, texcoord + tap(footprint, i) * per_texel, lod);
    }
}

// A triangle's relief, seen in three projections along the axes.
struct AxisViews {
    RestTriangle rest;
    vec3 normal;
    vec3 weights; // weights of the slopes
    mat2x3 weights_by_uv;
    mat2 by_uv[3];
    int foremost; // the view that has the largest weight
};

AxisViews axis_views(const uint index, const vec2 patch_uv) {
    AxisViews views;
    views.rest = rest_triangle(patches[index]);
    views.normal = rest_normal(views.rest, patch_uv);
    views.weights = relief_weights(views.normal);
    views.weights_by_uv = relief_weights_by_uv(views.rest, patch_uv, views.normal);
    for (int axis = 0; axis < 3; ++axis) {
        views.by_uv[axis] = seen_by_uv(views.rest, axis, views.normal);
    }
    vec3 w = views.weights;
    views.foremost = w.x >= max(w.y, w.z) ? 0 : (w.y >= w.z ? 1 : 2);
    return views;
}

// Computes the moments by position of a relief that is projected along the axes, and its classes. The views are uncorrelated, so their
// covariances add.
void filter_axis_moments(const AxisViews views, const vec2 patch_uv, const mat2 across, inout Means means, inout ClassParts parts) {
    vec2 mean = vec2(0.0);
    vec3 covariance = vec3(0.0), heights = vec3(0.0);
    int seen_views = 0;
    float level = mean_height(height_map);
    for (int axis = 0; axis < 3; ++axis) {
        if (views.weights[axis] > 0.0) {
            vec2 seen = seen_at(views.rest, axis, patch_uv, views.normal);
            Footprint footprint = footprint_in(Chart(seen, views.by_uv[axis] * across), moments_a, OF_SLOPES, 1);
            if (CLASSES > 1) {
                ClassMeans classes = no_class_means();
                filter_classes(footprint, seen, classes, means);
                vec2 variance = covariance_from_moments(means.mean, means.second).xy;
                add_class_parts(parts, seen_views, classes, means.mean, variance, transpose(views.by_uv[axis]), views.weights[axis]);
                ++seen_views;
            } else {
                filter_moments(footprint, seen, means);
            }
            heights[axis] = textureLod(height_map, seen, footprint.lod).x - level;
            // The chain rule gives the gradients by position.
            mat2 gradient = transpose(views.by_uv[axis]) * views.weights[axis];
            mean += gradient * means.mean;
            covariance += map_second_moments(gradient, covariance_from_moments(means.mean, means.second));
        }
    }
    // Where one view blends into another, the difference between their heights adds a slope.
    mean += heights * views.weights_by_uv;
    means.mean = mean;
    means.second = covariance + vec3(mean * mean, mean.x * mean.y);
    for (int k = 0; k < MOST_CLASSES; ++k) {
        parts.part[k].mean += mean;
    }
}

void filter_material(const Footprint footprint, const vec2 texcoord, inout Means means) {
    vec4 color = vec4(0.0);
    vec3 f0 = vec3(0.0);
    for (int i = 0; i < footprint.taps; ++i) {
        vec2 at = texcoord + tap(footprint, i) / vec2(textureSize(color_map, 0));
        color += linear_color(textureLod(color_map, at, footprint.lod));
        if (REFLECTS_BY_MAP) {
            f0 += textureLod(f0_map, at, footprint.lod).rgb;
        }
    }
    float weight = 1.0 / float(footprint.taps);
    means.color = color * weight;
    means.f0 = f0 * weight;
}

// Filters a material tiled by example. The values are blended about their mean.
void filter_tiled_material(Footprint footprint, OffsetVariants variants, const vec2 texcoord, inout Means means) {
    vec4 color = vec4(0.0), color_mean = linear_color(map_mean(color_map));
    vec3 f0 = vec3(0.0), f0_mean = REFLECTS_BY_MAP ? map_mean(f0_map).rgb : vec3(0.0);
    float part = FINEST_LEVEL ? 1.0 : tiling_part(variants, color_map, footprint.lod);
    variants = merged_at(variants, footprint.level);
    vec2 per_texel = 1.0 / vec2(textureSize(color_map, 0)), middle = texcoord + tiling_shift();
    for (TapVariant now = first_variant(variants); now.tap < footprint.taps; next_variant(now, variants)) {
        vec2 seen = middle + now.from + tap(footprint, now.tap) * per_texel;
        float weight = now.weight * part;
        color += weight * (linear_color(textureLod(color_map, seen, footprint.lod)) - color_mean);
        if (REFLECTS_BY_MAP) {
            f0 += weight * (textureLod(f0_map, seen, footprint.lod).rgb - f0_mean);
        }
    }
    float weight = 1.0 / float(footprint.taps);
    means.color = clamp(color_mean + color * weight, 0.0, 1.0);
    means.f0 = clamp(f0_mean + f0 * weight, 0.0, 1.0);
}

// Returns the coordinates of an image of the material. texcoord and texcoord_across belong to the mesh.
Chart chart_of(const uint chart, const uint index, const vec2 patch_uv, const mat2 across, vec2 texcoord, const mat2 texcoord_across) {
    if (CHARTED) {
        TriangleTexcoord texcoord = charted_texcoord(charts[index], chart);
        return Chart(texcoord.first + texcoord.by_uv * patch_uv, texcoord.by_uv * across);
    }
    return Chart(texcoord, texcoord_across);
}

// Returns the mean of a map over a footprint.
vec4 filter_map(sampler2D map, const Chart chart, OffsetVariants variants) {
    Footprint footprint = footprint_in(chart, map, OF_IMAGE, 1);
    vec4 sum = vec4(0.0);
    if (BY_EXAMPLE) {
        // The values are blended by shares, since they may be directions.
        variants = merged_at(variants, footprint.level);
        for (TapVariant now = first_variant(variants); now.tap < footprint.taps; next_variant(now, variants)) {
            vec2 at = chart.at + tiling_shift() + now.from + tap(footprint, now.tap) / vec2(textureSize(map, 0));
            sum += now.weight * now.weight * textureLod(map, at, footprint.lod);
        }
        return sum / float(footprint.taps);
    }
    for (int i = 0; i < footprint.taps; ++i) {
        sum += textureLod(map, chart.at + tap(footprint, i) / vec2(textureSize(map, 0)), footprint.lod);
    }
    return sum / float(footprint.taps);
}

// Returns the mean cone of a map that is projected along the axes, in the world. The views are mixed by the squares of their weights.
vec4 filter_axis_cone(const AxisViews views, const Macrosurface surface, const bool behind, const mat2 across) {
    vec4 sum = vec4(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        if (views.weights[axis] > 0.0) {
            vec2 seen = seen_at(views.rest, axis, surface.texcoord, views.normal);
            vec4 cone = filter_map(occlusion_map, Chart(seen, views.by_uv[axis] * across), NO_VARIANTS);
            vec3 open = cone_on_surface(surface, views.by_uv[axis], behind, cone.xyz);
            sum += views.weights[axis] * views.weights[axis] * vec4(open, cone.w);
        }
    }
    return sum;
}

// The level of the horizon within the footprint: 0 is as coarse as the footprint is wide, and 1 is as coarse as it is long. The value was
// measured: with a finer level, the horizon repeats shadows of the slope statistics, and with a coarser level, long footprints lose
// shadows.
const float WIDER = 0.25;
// Most taps of the horizon along the footprint. One tap would decide for the whole pixel whether a light is hidden, so cracks
// would become isolated black pixels.
const int HORIZON_TAPS = 4;

// Returns the horizon of bumps that are larger than the footprint. The slope statistics account for smaller bumps.
Horizon filter_horizon(const Footprint footprint, const uint index, const vec2 texcoord, const mat2 linear, const float scale) {
    float lod = mix(footprint.across, footprint.widest, WIDER), part = scale;
    if (ATLAS) {
        // The coarse levels store no horizon.
        part *= levels_at(lod).fine;
        lod = min(lod, float(SOURCE_LEVEL));
    }
    // The horizons of large maps start at a coarser level.
    int count = ATLAS ? 1 : clamp(int(exp2(footprint.widest - lod) + 0.5), 1, HORIZON_TAPS);
    vec2 whole = footprint.step * float(footprint.taps / footprint.rows) / vec2(textureSize(moments_a, 0));
    lod -= log2(float(textureSize(moments_a, 0).x) / float(textureSize(horizon_a, 0).x));
    vec2 lean = vec2(0.0);
    vec3 spread = vec3(0.0);
    for (int i = 0; i < count; ++i) {
        vec2 at = texcoord + whole * ((float(i) + 0.5) / float(count) - 0.5);
        vec4 a = textureLod(horizon_a, at, lod);
        float correlation = textureLod(horizon_b, at, lod).x;
        lean += a.xy;
        spread += vec3(a.zw * a.zw, correlation * a.z * a.w);
    }
    part /= float(count);
    return Horizon(linear * (part * lean), map_second_moments(linear, spread * (part * part * float(count))));
}

// Returns the horizon of a relief tiled by example. The variants are blended by shares. Shadows that the bumps of one variant cast on
// another variant are ignored.
Horizon filter_tiled_horizon(const Footprint footprint, const uint index, OffsetVariants variants, const vec2 texcoord, const mat2 linear,
                             const float scale) {
    Horizon sum = Horizon(vec2(0.0), vec3(0.0));
    vec2 at = texcoord + tiling_shift();
    variants = merged_at(variants, footprint.level);
    int count = tiling_count(variants);
    for (int k = 0; k < count; ++k) {
        float share = variants.of.a.weight * variants.of.a.weight;
        Horizon seen = filter_horizon(footprint, index, at + variants.from_a, linear, scale);
        sum.lean += share * seen.lean;
        sum.spread += share * seen.spread;
        next_variant(variants);
    }
    return sum;
}

// Returns the horizon of a relief projected along the axes.
Horizon filter_axis_horizon(const AxisViews views, const Footprint footprint, const uint index, const vec2 patch_uv, const mat2 linear,
                            const float scale) {
    Horizon sum = Horizon(vec2(0.0), vec3(0.0));
    for (int axis = 0; axis < 3; ++axis) {
        if (views.weights[axis] > 0.0) {
            mat2 by_view = linear * transpose(views.by_uv[axis]) * views.weights[axis];
            Horizon seen = filter_horizon(footprint, index, seen_at(views.rest, axis, patch_uv, views.normal), by_view, scale);
            sum.lean += seen.lean;
            sum.spread += seen.spread;
        }
    }
    return sum;
}

// The limits of the refinement: the largest displacement in footprints, and the smallest sine of a ray's elevation.
const float MOST_REFINED = 2.0;
const float LEAST_RISE = 0.05;
// The smallest rate at which the gap between ray and relief closes, per height of the ray. The rate is -1 over flat relief, and 0 where ray
// and relief are parallel. Each step uses at least this magnitude.
const float LEAST_CLOSING = 0.3;

// Returns the height of the map at one height scale. passing is the slope described at tiled_height.
float map_height(const uint index, OffsetVariants variants, const float scale, const vec2 texcoord, float lod, out vec2 passing) {
    passing = vec2(0.0);
    if (TRIPLANAR) {
        return triplanar_height(rest_triangle(patches[index]), texcoord, height_map, lod) * scale;
    }
    if (BY_EXAMPLE) {
        return tiled_height(height_map, variants, texcoord + tiling_shift(), lod, passing) * scale;
    }
    vec4 tile = ATLAS ? patch_tile(patches[index]) : vec4(0.0);
    vec2 at = ATLAS ? clamp_to_tile(texcoord, tile, lod, textureSize(height_map, 0)) : texcoord;
    return textureLod(height_map, at, lod).x * scale;
}

// Returns the height of the map and of a detail that displaces. level is the level of detail of the detail, relative to that of the heights.
float relief_height(const uint index, OffsetVariants variants, const float scale, const vec2 texcoord, float lod, float level,
                    out vec2 passing) {
    float height = map_height(index, variants, scale, texcoord, lod, passing);
    return DETAIL_DISPLACES ? height + detail_height(texcoord, level) * OBJECT.height_scale : height;
}

// Returns the texture coordinate at which a ray meets the relief. The geometry is a triangle, flat between its vertices. From its hit
// point, the search takes one step as over flat relief, and then one secant step. texels is the number of texels per texture coordinate,
// and longest is the length of the footprint in texels.
vec2 refined_texcoord(uint index, OffsetVariants variants, const float scale, const Macrosurface surface, const vec3 ray, const mat2 texels,
                      float lod, float level, const float longest, out vec2 passing) {
    vec3 normal = cross(surface.tangent_s, surface.tangent_t);
    float square = max(dot(normal, normal), 1e-30);
    float rise = min(dot(ray, surface.normal), -LEAST_RISE * length(ray));
    vec2 per_height = vec2(dot(ray, cross(surface.tangent_t, normal)), dot(ray, cross(normal, surface.tangent_s))) / (square * rise);
    float most = MOST_REFINED * longest / max(length(texels * per_height), 1e-20);
    float gap = relief_height(index, variants, scale, surface.texcoord, lod, level, passing) - surface.height;
    float climbed = clamp(gap, -most, most);
    float there = relief_height(index, variants, scale, surface.texcoord + per_height * climbed, lod, level, passing);
    float gap_there = there - surface.height - climbed;
    float closing = min((gap_there - gap) / (abs(climbed) > 1e-12 ? climbed : -1e12), -LEAST_CLOSING);
    return surface.texcoord + per_height * clamp(climbed - gap_there / closing, -most, most);
}

// Returns the weight of the joined edge samples against the pixel's own footprint. The weight is 0 for footprints below an eighth of a
// patch, where the patch's maps are complete, and 1 from a quarter of a patch on.
float joined_part(const float lod) {
    return clamp(lod - log2(tile_inner()) + 3.0, 0.0, 1.0);
}

// Filters a pixel of the object. at is the position of the pixel in the image, in pixels; it differs from `pixel` for the lists of
// msaa.comp. area returns the area of the macrosurface within the pixel, projected along its displacement direction, in square metres.
FilteredSurface filtered_mesh(const ivec2 pixel, vec2 at, uvec4 seen, out float area) {
    // Helper invocations and discarded pixels run with the data of another object, whose patch numbers may exceed this object's buffers.
    seen.xyz = object_of(seen.x) == OBJECT.number ? seen.xyz : uvec3(0u);
    // The ray through the pixel, up to the surface.
    vec2 step = vec2(VIEW.ray_x.w, VIEW.ray_y.w), ndc = at * step - 1.0;
    vec3 ray = VIEW.ray_middle.xyz + ndc.x * VIEW.ray_x.xyz + ndc.y * VIEW.ray_y.xyz;
    float along = VIEW.ray_middle.w / texelFetch(visible_depth, pixel, 0).x;
    uint index = seen.x & PATCH_BITS;
    vec2 patch_uv = uintBitsToFloat(seen.yz);
    bool behind = TRIANGLES && (seen.x & INSIDE) != 0u;
    Macrosurface surface = macrosurface_at(index, patch_uv, ray * along, behind);

    // An edge sample on its pixel's own surface covers a part of the pixel. join.comp joins all of these samples.
    bool joined = (seen.x & OF_THE_PIXEL) != 0u;
    uint grid = EDGE_SAMPLES ? VIEW.edge_grid : 0u;
    // Edge samples use finer geometry, and derivatives of its triangles. The weight of an edge sample is the surface area that it contains
    // (join.comp).
    mat2 across = grid == 0u ? pixel_footprint(surface, ray, along, step)
                             : unpack_footprint(texelFetch(visible_footprint, pixel, 0).xy) * (joined ? 1.0 / float(grid) : 1.0);
    vec2 size = vec2(textureSize(moments_a, 0));
    mat2 texcoord_across = surface.texcoord_by_uv * across;
    mat2 texels = mat2(size.x, 0.0, 0.0, size.y);
    AxisViews views;
    if (TRIPLANAR) {
        views = axis_views(index, patch_uv);
        texels *= views.by_uv[views.foremost];
    }
    mat2 texels_across = texels * texcoord_across;
    vec2 dx = clamp(texels_across[0], -6e4, 6e4), dy = clamp(texels_across[1], -6e4, 6e4);
    Frame frame = frame_about(surface.normal);
    vec3 curvature = vec3(0.0);
    mat2 rotation = mat2(0.0);
    if (USES_CURVATURE && !FLAT) {
        // The macro normal rotates across the pixel; the rotation is expressed as differences of slopes.
        rotation = mat2(to_frame(frame, surface.normal_by_uv * across[0]).xy, to_frame(frame, surface.normal_by_uv * across[1]).xy);
        curvature = add_macro_curvature(curvature, -rotation[0], -rotation[1]);
    }

    Means means = NO_MEANS;
    ClassMeans classes;
    ClassParts parts;
    if (CLASSES > 1) {
        classes = no_class_means();
        parts = no_class_parts();
    }
    vec2 drawn = surface.texcoord;
    Footprint footprint = footprint_over(dx, dy, ATLAS ? tile_inner() : 1e9, OF_SLOPES, TAP_ROWS);
    if (FINEST_LEVEL && DISPLACED && !ATLAS && !TRIANGLES) {
        // Bumps between the vertices of a fully divided patch are not drawn, so a viewer does not see more of their facing sides. The slope
        // statistics do this instead.
        // The position on a flat object is its texture coordinate, not the position on its patch.
        PatchTexcoord corner = patch_texcoord(patches[index], 0.0, 0.0);
        mat2 apart = texels * (FLAT ? mat2(corner.du, corner.dv) : surface.texcoord_by_uv) / MAX_FACTOR;
        if (max(dot(apart[0], apart[0]), dot(apart[1], apart[1])) > 1.0) {
            footprint = elliptical_footprint(apart[0], apart[1], 1e9, OF_SLOPES, 1);
        }
    }
    OffsetVariants variants = NO_VARIANTS;
    vec2 passing = vec2(0.0);
    if (BY_EXAMPLE) {
        variants = offset_variants(surface.texcoord + tiling_shift(), OBJECT.flags);
    }
    HeightScale eta = FULL_HEIGHT_SCALE;
    if (DISPLACED && HEIGHT_SCALED) {
        eta = filter_height_scale(index, patch_uv, surface.texcoord, surface.texcoord_by_uv, across);
    }
    if (DISPLACED && RELIEF_DRAWN && (!TRIANGLES || surface.slopes > 0.0) && !FINEST_LEVEL && grid == 0u) {
        float longest = sqrt(max(dot(dx, dx), dot(dy, dy)));
        float scale_here = OBJECT.height_scale * eta.mean, level_of_detail = 0.0;
        if (DETAIL_DISPLACES) {
            float fine = exp2(OBJECT.detail_lod);
            level_of_detail = detail_footprint(dx * fine, dy * fine, OF_SLOPES).level - OBJECT.detail_lod;
        }
        if (ATLAS) {
            // The coarser levels of a tile do not match those of its neighbours.
            vec2 refined = refined_texcoord(index, variants, scale_here, surface, ray, texels, min(footprint.level, float(SOURCE_LEVEL)), 0.0,
                                            longest, passing);
            surface.texcoord = mix(refined, surface.texcoord, clamp(footprint.level - float(SOURCE_LEVEL), 0.0, 1.0));
        } else {
            surface.texcoord = refined_texcoord(index, variants, scale_here, surface, ray, texels, footprint.level, level_of_detail, longest,
                                                passing);
        }
    }
    if (ATLAS) {
        vec2 lengths = vec2(length(surface.tangent_s), length(surface.tangent_t));
        vec2 on_patch = patch_uv_at(index, surface.texcoord * size);
        means = filter_atlas(footprint, index, on_patch, max(lengths, 1e-20), classes);
        if (CONES) {
            vec4 cone = filter_atlas_cone(footprint, index, on_patch);
            means.cone = vec4(cone_on_surface(surface, surface.texcoord_by_uv, behind, cone.xyz), cone.w);
        }
    } else {
        if (USES_SLOPES && DISPLACED && TRIPLANAR) {
            filter_axis_moments(views, surface.texcoord, texcoord_across, means, parts);
        } else if (USES_SLOPES && DISPLACED && BY_EXAMPLE) {
            if (FINEST_LEVEL || !RELIEF_DRAWN) {
                tiled_height(height_map, variants, surface.texcoord + tiling_shift(), footprint.level, passing);
            }
            filter_tiled_moments(footprint, variants, surface.texcoord, passing, means);
            if (CLASSES > 1) {
                filter_tiled_classes(footprint, variants, surface.texcoord, classes);
            }
        } else if (CLASSES > 1) {
            filter_classes(footprint, surface.texcoord, classes, means);
        } else if (USES_SLOPES && DISPLACED) {
            filter_moments(footprint, surface.texcoord, means);
        }
        if (COLORED) {
            Chart chart = chart_of(CHART_COLORS, index, patch_uv, across, surface.texcoord, texcoord_across);
            Footprint of_colors = footprint_in(chart, color_map, OF_IMAGE, TAP_ROWS);
            if (BY_EXAMPLE) {
                filter_tiled_material(of_colors, variants, chart.at, means);
            } else {
                filter_material(of_colors, chart.at, means);
            }
            if (CLASSES > 1 && CLASS_COLORS) {
                filter_class_colors(of_colors, variants, chart.at, classes);
                if (!DISPLACED) {
                    classes_of_material(classes);
                }
            }
        }
        if (EMITS) {
            Chart chart = chart_of(CHART_EMISSION, index, patch_uv, across, surface.texcoord, texcoord_across);
            means.light.rgb = filter_map(emission_map, chart, variants).rgb;
        }
        if (CONES && TRIPLANAR) {
            means.cone = filter_axis_cone(views, surface, behind, texcoord_across);
        } else if (OCCLUDED) {
            Chart chart = chart_of(CHART_OCCLUSION, index, patch_uv, across, surface.texcoord, texcoord_across);
            vec4 seen = filter_map(occlusion_map, chart, variants);
            if (CONES) {
                mat2 by_uv = CHARTED ? charted_texcoord(charts[index], CHART_OCCLUSION).by_uv : surface.texcoord_by_uv;
                means.cone = vec4(cone_on_surface(surface, by_uv, behind, seen.xyz), seen.w);
            } else {
                means.light.a = seen.x;
            }
        }
    }
    // Height scale and relief are assumed to be uncorrelated within the pixel, so the square of the scale has its own mean.
    float scale = OBJECT.height_scale * surface.slopes * sqrt(eta.mean * eta.mean + eta.variance);
    vec2 mean_gradient = means.mean * (OBJECT.height_scale * surface.slopes * eta.mean);
    vec3 gradient_covariance = scale_height(covariance_from_moments(means.mean, means.second), scale);
    vec4 color = surface.color;
    if (COLORED) {
        color *= vec4(means.color.rgb, sqrt(means.color.a));
    }
    vec3 tinted = vec3(1.0);
    if (GROUND) {
        mat2 metres = mat2(length(OBJECT.tangent_s.xyz), 0.0, 0.0, length(OBJECT.tangent_t.xyz));
        tinted = ground_tint(metres * (surface.texcoord + tiling_shift()), metres * texcoord_across);
        color.rgb *= tinted;
    }
    DetailMeans covering = DetailMeans(vec2(0.0), vec3(0.0), vec4(0.0), 0.0);
    vec3 chart_s = surface.tangent_s, chart_t = surface.tangent_t;
    float chart_area = dot(cross(surface.tangent_s, surface.tangent_t), surface.normal);
    SlopeMap chart = slope_map(surface.tangent_s, surface.tangent_t, frame.x, frame.y, frame.z), map = chart;
    if (RISE_OVER_RUN) {
        surface.tangent_s *= inversesqrt(max(dot(surface.tangent_s, surface.tangent_s), 1e-30));
        surface.tangent_t *= inversesqrt(max(dot(surface.tangent_t, surface.tangent_t), 1e-30));
        map = slope_map(surface.tangent_s, surface.tangent_t, frame.x, frame.y, frame.z);
    }
    vec2 mean_slope = map_mean_slope(map, mean_gradient);
    vec3 map_statistics = map_covariance(map, gradient_covariance);
    if (DISPLACED && HEIGHT_SCALED && USES_SLOPES) {
        // d(eta h) = eta dh + h d(eta). The covariance leaves out the second term (theory, section 5).
        vec2 passing_here;
        float level = ATLAS ? min(footprint.level, float(SOURCE_LEVEL)) : footprint.level;
        float height = map_height(index, variants, OBJECT.height_scale * surface.slopes, surface.texcoord, level, passing_here);
        SlopeMap by_uv = slope_map(surface.by_uv[0], surface.by_uv[1], frame.x, frame.y, frame.z);
        mean_slope += mat2(by_uv.linear_s, by_uv.linear_t) * (height * eta.by_uv);
        vec2 unscaled = means.mean * (OBJECT.height_scale * surface.slopes);
        vec3 square = vec3(unscaled * unscaled, unscaled.x * unscaled.y) * eta.variance;
        map_statistics = clamp_covariance(map_statistics + map_second_moments(mat2(map.linear_s, map.linear_t), square));
    }
    if (DETAIL != DETAIL_NONE) {
        vec2 there = patch_uv;
        if (abs(determinant(surface.texcoord_by_uv)) > 1e-20) {
            there += inverse(surface.texcoord_by_uv) * (surface.texcoord - drawn);
        }
        SlopeMap by_uv = slope_map(surface.by_uv[0], surface.by_uv[1], frame.x, frame.y, frame.z);
        DetailMeans detail = filter_detail(index, there, surface.texcoord, surface.texcoord_by_uv, across,
                                           mat2(by_uv.linear_s, by_uv.linear_t) * detail_factor());
        if (USES_SLOPES) {
            mean_slope += detail.slope;
            if (!DETAIL_IN_GLOSS) {
                map_statistics = clamp_covariance(map_statistics + detail.covariance);
            }
        }
        if (DETAIL_COLORS != DETAIL_COLORLESS) {
            vec4 covered = color_with_detail(vec4(color.rgb, color.a * color.a), detail);
            color = vec4(covered.rgb, sqrt(covered.a));
            covering = detail;
        }
        if (DETAIL_IN_GLOSS) {
            color.a = alpha_with_detail(color.a, mean_slope, detail);
        }
    }
    // At the finest level, the covariance includes the spread between neighbouring texels, because bilinear interpolation of the mean loses
    // this spread. With it, the variance is the same at every magnification.
    vec3 covariance = technique_covariance(map_statistics, vec3(0.0));
    if (USES_CURVATURE && !PER_LIGHT_KERNEL && !FLAT) {
        covariance += kernel_over(tilt_kernel(curvature, mean_slope), add_roughness(covariance, color.a));
    }

    FilteredSurface filtered;
    filtered.normal = surface.normal;
    filtered.mean_slope = mean_slope;
    filtered.covariance = covariance;
    filtered.material = color;
    filtered.f0 = REFLECTS_BY_MAP ? means.f0 : vec3(OBJECT.specular_f0);
    filtered.diffuse_f0 = OBJECT.specular_f0;
    filtered.edge_tint = unpack_edge_tint(OBJECT.edge_tint);
    filtered.fit = OBJECT.fit;
    vec3 tint = (OBJECT.flags & FLAG_TINTED_EMISSION) != 0u ? surface.color.rgb : vec3(1.0);
    filtered.emission = EMITS ? means.light.rgb * tint : vec3(0.0);
    filtered.accessibility = surface.accessibility * (OCCLUDED ? means.light.a : 1.0);
    if (DETAIL_COLORS == DETAIL_COVERS) {
        // Where the detail covers the material, it replaces the specular and metallic properties.
        filtered.f0 = mix(filtered.f0, vec3(detail_color.a), covering.cover);
        filtered.diffuse_f0 = mix(filtered.diffuse_f0, detail_color.a, covering.cover);
        filtered.edge_tint *= 1.0 - covering.cover;
    }
    filtered.inside = (seen.x & INSIDE) != 0u && (!TRIANGLES || (OBJECT.flags & FLAG_MARK_INSIDE) != 0u);
    filtered.horizon = Horizon(vec2(0.0), vec3(0.0));
    if (USES_HORIZON && DISPLACED && HORIZON && (!TRIANGLES || surface.slopes > 0.0)) {
        mat2 linear = mat2(chart.linear_s, chart.linear_t);
        float height = abs(OBJECT.height_scale) * eta.mean;
        filtered.horizon = TRIPLANAR ? filter_axis_horizon(views, footprint, index, surface.texcoord, linear, height)
                         : BY_EXAMPLE     ? filter_tiled_horizon(footprint, index, variants, surface.texcoord, linear, height)
                                     : filter_horizon(footprint, index, surface.texcoord, linear, height);
    }
    filtered.cone = CONES ? vec4(to_frame(frame, means.cone.xyz), means.cone.w) : NO_CONE;
    filtered.medium = OBJECT.medium;
    filtered.coat = NO_COAT;
    if (COATED) {
        filtered.coat = Coat(OBJECT.coat.x, OBJECT.coat.y, OBJECT.coat.z > 0.5, vec2(0.0), vec3(0.0));
        if (COAT_MAP && !ATLAS) {
            vec4 first;
            vec3 second;
            filter_coat(chart_of(CHART_COLORS, index, patch_uv, across, surface.texcoord, texcoord_across), first, second);
            vec3 s = chart_s * inversesqrt(max(dot(chart_s, chart_s), 1e-30)), t = chart_t * inversesqrt(max(dot(chart_t, chart_t), 1e-30));
            SlopeMap of_coat = slope_map(s, t, frame.x, frame.y, frame.z);
            filtered.coat.weight = first.x;
            filtered.coat.alpha = sqrt(max(first.y, 0.0));
            filtered.coat.mean_slope = map_mean_slope(of_coat, first.zw);
            filtered.coat.covariance = map_covariance(of_coat, covariance_from_moments(first.zw, second));
        }
        if (USES_CURVATURE && !FLAT) {
            filtered.coat.covariance += kernel_over(tilt_kernel(curvature, filtered.coat.mean_slope),
                                                    add_roughness(filtered.coat.covariance, filtered.coat.alpha));
        }
    }
    filtered.lod = footprint.level;
    filtered.joined = JOINS_EDGES ? joined_part(footprint.across) : 0.0;
    filtered.relief = OBJECT.relief;
    filtered.rotation = rotation;
    if (CLASSES > 1) {
        // Detail and curvature are independent of the classes.
        SlopeMap class_map = map;
        if (ATLAS) {
            mat2x3 aligned = mat2x3(normalize(surface.tangent_s), normalize(surface.tangent_t)) * transpose(aligned_slopes(index));
            class_map = slope_map(aligned[0], aligned[1], frame.x, frame.y, frame.z);
        }
        vec2 joined = means.mean;
        vec3 joined_second = means.second;
        if (BY_EXAMPLE || ATLAS) {
            // The variants of a tiled relief are blended, so the classes move to the slope of the blend.
            joined_class_moments(classes, joined, joined_second);
        }
        vec2 slope = mean_slope - map_mean_slope(class_map, scale * joined);
        vec3 added = covariance - map_covariance(map, gradient_covariance);
        vec4 material = CLASS_COLORS ? means.color : color;
        if (!TRIPLANAR) {
            parts = class_parts(classes, ATLAS ? covariance_from_moments(joined, joined_second).xy
                                               : covariance_from_moments(means.mean, means.second).xy);
        }
        filtered.classes = facet_classes(parts, classes, scale, class_map, slope, added, material,
                                         vec4(surface.color.rgb * tinted, surface.color.a));
        if (TRIPLANAR) {
            filtered.classes.views = 0;
            for (int axis = 0; axis < 3; ++axis) {
                if (views.weights[axis] > 0.0) {
                    mat2 linear = mat2(map.linear_s, map.linear_t) * transpose(views.by_uv[axis]);
                    add_openness_view(filtered.classes, linear, scale, views.weights[axis] * views.weights[axis]);
                }
            }
        }
        if (CLASS_COLORS && DETAIL_COLORS != DETAIL_COLORLESS) {
            [[unroll]] for (int n = 0; n < CLASSES; ++n) {
                vec4 own = filtered.classes.material[n];
                vec4 covered = color_with_detail(vec4(own.rgb, own.a * own.a), covering);
                filtered.classes.material[n] = vec4(covered.rgb, sqrt(covered.a));
            }
        }
        if (ATLAS) {
            // Footprints below the finest level of the classes have one class.
            float one = clamp(first_class_level(size) - footprint.lod, 0.0, 1.0);
            [[unroll]] for (int n = 0; n < CLASSES; ++n) {
                filtered.classes.mean[n] = mix(filtered.classes.mean[n], mean_slope, one);
                filtered.classes.covariance[n] = mix(filtered.classes.covariance[n], covariance, one);
                filtered.classes.material[n] = mix(filtered.classes.material[n], color, one);
            }
        }
    }
    area = abs(determinant(texcoord_across) * chart_area);
    return filtered;
}

#endif
