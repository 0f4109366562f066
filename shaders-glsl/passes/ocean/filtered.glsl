// Filters the waves under each pixel of the sea: the slope moments of all cascades by the sum rule, the slopes of waves shorter than the
// finest cascade, and the foam where the surface folds.
#ifndef LEADR_OCEAN_FILTERED
#define LEADR_OCEAN_FILTERED
#include "../constants.glsl"
#include "../technique.glsl"
#include "cascade.glsl"
#include "shore.glsl"
#include "water.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"
#include "leadr/facets/normal_distribution.glsl"
#include "leadr/slopes/statistics.glsl"

layout(constant_id = 40) const int MAX_TAPS = 8;
layout(constant_id = 48) const bool HAS_BEACH = false;

uniform usampler2D visible_surface;
uniform usampler2D visible_footprint;
uniform sampler2DArray slopes; // w sx, w sy, w sx^2, w sy^2
uniform sampler2DArray joint;  // w sx sy, w, stretch, stretch^2
layout(std430) readonly buffer Cascades { Cascade cascades[]; };
layout(std140) uniform Beach { Shore shore; };

// Filters a pixel of the sea.
FilteredSurface filtered_sea(const ivec2 pixel, const uvec4 seen) {
    vec2 away = uintBitsToFloat(seen.yz), at = away + water.centre.xy;
    uvec2 footprint = texelFetch(visible_footprint, pixel, 0).xy;
    vec2 dx = unpackHalf2x16(footprint.x), dy = unpackHalf2x16(footprint.y);
    int count = textureSize(slopes, 0).z;
    float samples = float(textureSize(slopes, 0).x), last = log2(samples);

    // The curvature of the earth adds a slope away from the centre.
    vec2 mean = -away * water.centre.z;
    vec3 tail = water.tail.xyz; // covariance of waves shorter than the finest cascade
    float area = 1.0, area_variance = 0.0, finest = 0.0;
    float xx = dot(dx, dx), yy = dot(dy, dy);
    vec2 along = xx > yy ? dx : dy;
    float major = sqrt(max(xx, yy)), minor = abs(dx.x * dy.y - dx.y * dy.x) / max(major, 1e-20);
    // Over a beach, the swell adds its slope, shallow water has no ripples, and each cascade fades with the depth.
    ShoreWater beach;
    beach.depth = 0.0;
    if (HAS_BEACH) {
        beach = shore_water(shore, at, FINEST_LEVEL ? 0.0 : major);
        mean += beach.slope;
        tail *= clamp(beach.depth / 0.15, 0.02, 1.0);
    }
    vec3 covariance = tail;
    if (HAS_BEACH && !FINEST_LEVEL) {
        covariance.x += beach.variance;
    }
    for (int i = 0; i < count; ++i) {
        Cascade c = cascades[i];
        float calm = HAS_BEACH ? shore_calm(shore, i, beach.depth) : 1.0;
        float texels = samples / c.size;
        int taps = clamp(int(ceil(major / max(minor, 1.0 / texels))), 1, MAX_TAPS);
        float lod = clamp(log2(max(max(major / float(taps), minor) * texels, 1.0)), 0.0, last);
        if (FINEST_LEVEL) {
            lod = 0.0;
        }
        if (FINEST_LEVEL || lod >= last) { // the last level has constant values
            taps = 1;
        }
        vec4 a = vec4(0.0), b = vec4(0.0);
        for (int k = 0; k < taps; ++k) {
            vec2 point = at + along * ((float(k) + 0.5) / float(taps) - 0.5);
            vec3 texcoord = vec3(cascade_texcoord(c, point), float(i));
            a += textureLod(slopes, texcoord, lod);
            b += textureLod(joint, texcoord, lod);
        }
        float inverse = 1.0 / max(b.y, 1e-6); // one over the area of the displaced sea
        vec2 m = a.xy * inverse;
        mean += calm * m;
        if (!FINEST_LEVEL) {
            covariance += calm * calm * covariance_from_moments(m, vec3(a.zw, b.x) * inverse);
        }
        float weight = 1.0 / float(taps);
        area += calm * (b.z * weight - 1.0);
        area_variance += calm * calm * max(b.w * weight - b.z * b.z * weight * weight, 0.0);
        finest = max(finest, lod);
    }

    covariance = technique_covariance(covariance, tail);

    // The fraction of the pixel whose stretch is below the threshold.
    float spread = sqrt(area_variance) + 1e-3;
    float covered = normal_cdf((water.foam.w - area) / spread);

    vec3 color = water.color.rgb;
    float alpha = water.tail.w;
    if (HAS_BEACH) {
        // Light from the sand passes through the water twice.
        color = mix(color, shore.bed.rgb, exp(-2.0 * shore.extinction.rgb * max(beach.depth, 0.0)));
        alpha = mix(0.1, alpha, smoothstep(0.0, 0.04, beach.depth));
        covered = 1.0 - (1.0 - covered) * (1.0 - shore_foam(beach, FINEST_LEVEL ? 0.0 : major));
    }

    vec4 material = vec4(mix(color, water.foam.rgb, covered), mix(alpha, 0.6, covered));
    FilteredSurface sea = filtered_water(mean, covariance, material, water.color.w * (1.0 - covered));
    sea.lod = finest;
    return sea;
}

#endif
