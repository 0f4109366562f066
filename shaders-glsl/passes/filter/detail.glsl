// A tiling detail on a surface. The slopes of the detail add to the slopes of the relief. The colours and roughness of the detail modulate
// or cover those of the surface. Each layer is filtered in its own footprint. Surface, detail and mask are assumed to be uncorrelated below
// the pixel size, so means add, covariances add, and the mean of a product is the product of the means (theory, section 5).
#ifndef LEADR_FILTER_DETAIL
#define LEADR_FILTER_DETAIL
#include "../constants.glsl"
#include "../geometry/detail_height.glsl"
#include "../triplanar.glsl"
#include "leadr/materials/classic.glsl"
#include "leadr/facets/shortened_normals.glsl"
#include "leadr/slopes/map.glsl"
#include "leadr/slopes/moments.glsl"

layout(constant_id = 60) const uint DETAIL = DETAIL_NONE;             // coordinates that the detail follows
layout(constant_id = 61) const uint DETAIL_COLORS = DETAIL_COLORLESS; // how the colours of the detail combine with the surface
layout(constant_id = 62) const bool DETAIL_MASKED = false;

layout(set = 2) uniform sampler2D detail_a;     // E[hs], E[ht], E[hs^2], E[ht^2], in metres per unit of the detail's coordinates
layout(set = 2) uniform sampler2D detail_b;     // E[hs ht]
layout(set = 2) uniform sampler2D detail_colors; // rgb: albedo; a: square root of the roughness alpha

// The mean values of the detail under a pixel.
struct DetailMeans {
    vec2 slope;      // mean slope, in the tangent frame
    vec3 covariance; // covariance of the slopes
    vec4 color;      // rgb: albedo; a: alpha^2
    float cover;     // fraction of the surface that the detail covers
};

// Adds the detail at the coordinates c of the surface. by_uv has the derivatives of c by position. linear converts gradients by position to
// slopes. weight is the weight of the slopes, and share is the weight of the colours.
void add_detail(inout DetailMeans sum, const vec2 c, const mat2 by_uv, const mat2 across, const mat2 linear, const float weight,
                const float share) {
    mat2 to_detail = mat2(detail_linear.xy, detail_linear.zw);
    mat2 detail_by_uv = to_detail * by_uv;
    vec2 size = vec2(textureSize(detail_a, 0));
    mat2 texels = detail_by_uv * across;
    Footprint footprint = detail_footprint(texels[0] * size, texels[1] * size, OF_SLOPES);
    vec2 at = to_detail * c + detail_offsets.xy;
    vec4 a = vec4(0.0);
    float b = 0.0;
    for (int i = 0; i < footprint.taps; ++i) {
        vec2 texcoord = at + tap(footprint, i) / size;
        a += textureLod(detail_a, texcoord, footprint.lod);
        if (USES_COVARIANCE) {
            b += textureLod(detail_b, texcoord, footprint.lod).x;
        }
    }
    float per_tap = 1.0 / float(footprint.taps);
    SlopeMoments moments = SlopeMoments(a.xy * per_tap, vec3(a.zw, b) * per_tap);
    vec2 mask = vec2(1.0);
    if (DETAIL_MASKED) {
        mat2 to_mask = mat2(mask_linear.xy, mask_linear.zw);
        vec2 mask_size = vec2(textureSize(detail_mask, 0));
        mat2 mask_texels = to_mask * by_uv * across;
        Footprint wide = detail_footprint(mask_texels[0] * mask_size, mask_texels[1] * mask_size, OF_IMAGE);
        vec2 there = to_mask * c + detail_offsets.zw;
        mask = vec2(0.0);
        for (int i = 0; i < wide.taps; ++i) {
            mask += textureLod(detail_mask, there + tap(wide, i) / mask_size, wide.lod).xy;
        }
        mask /= float(wide.taps);
        moments = mask_moments(moments, mask);
        if (DETAIL_DISPLACES) {
            // The geometry has the gradient of the mask too: d(m h) = m dh + h dm.
            float height = textureLod(coarse_b, at, footprint.lod).x;
            sum.slope += linear * (height * (gradient_of(detail_mask, there, wide.lod) * (to_mask * by_uv))) * weight;
        }
    }
    // By the chain rule, from the derivatives of the detail's coordinates by position.
    mat2 slopes = linear * transpose(detail_by_uv) * weight;
    sum.slope += slopes * moments.first;
    if (USES_COVARIANCE) {
        sum.covariance += map_second_moments(slopes, moments_covariance(moments));
    }
    if (DETAIL_COLORS != DETAIL_COLORLESS) {
        vec2 color_size = vec2(textureSize(detail_colors, 0));
        Footprint of_colors = detail_footprint(texels[0] * color_size, texels[1] * color_size, OF_IMAGE);
        vec4 color = vec4(0.0);
        for (int i = 0; i < of_colors.taps; ++i) {
            color += linear_color(textureLod(detail_colors, at + tap(of_colors, i) / color_size, of_colors.lod));
        }
        sum.color += color * (share / float(of_colors.taps));
    }
    sum.cover += share * mask.x;
}

// Returns the detail at a position on a patch. linear converts gradients by position to slopes in the frame.
DetailMeans filter_detail(const uint index, const vec2 patch_uv, vec2 texcoord, mat2 texcoord_by_uv, mat2 across, mat2 linear) {
    DetailMeans sum = DetailMeans(vec2(0.0), vec3(0.0), vec4(0.0), 0.0);
    if (DETAIL == DETAIL_BY_TEXCOORD) {
        add_detail(sum, texcoord, texcoord_by_uv, across, linear, 1.0, 1.0);
        return sum;
    }
    uvec4 corners = patches[index].vertices;
    vec3 p[4], n[4];
    for (int i = 0; i < 4; ++i) {
        p[i] = rest[corners[i]].position.xyz;
        n[i] = rest[corners[i]].normal.xyz;
    }
    vec3 position, normal;
    mat2x3 by_uv;
    if (TRIANGLES) {
        by_uv = mat2x3(p[1] - p[0], p[3] - p[0]);
        position = p[0] + by_uv * patch_uv;
        normal = n[0] + mat2x3(n[1] - n[0], n[3] - n[0]) * patch_uv;
    } else {
        vec3 low = mix(p[0], p[1], patch_uv.x), high = mix(p[3], p[2], patch_uv.x);
        by_uv = mat2x3(mix(p[1] - p[0], p[2] - p[3], patch_uv.y), high - low);
        position = mix(low, high, patch_uv.y);
        normal = mix(mix(n[0], n[1], patch_uv.x), mix(n[3], n[2], patch_uv.x), patch_uv.y);
    }
    normal *= inversesqrt(max(dot(normal, normal), 1e-20));
    vec3 weights = triplanar_weights(normal), of_relief = relief_weights(normal);
    float per_sum = 1.0 / max(weights.x + weights.y + weights.z, 1e-20);
    for (int k = 0; k < 3; ++k) {
        if (weights[k] > 0.0) {
            vec2 c = seen_along(k, position, normal) + TRIPLANAR_SHIFTS[k];
            mat2 seen_by_uv = mat2(seen_along(k, by_uv[0], normal), seen_along(k, by_uv[1], normal));
            add_detail(sum, c, seen_by_uv, across, linear, of_relief[k], weights[k] * per_sum);
        }
    }
    return sum;
}

// Returns the factor on the slopes of the detail. A detail that displaces has the height scale of the frame.
float detail_factor() {
    return DETAIL_DISPLACES ? OBJECT.height_scale * OBJECT.detail_unit : 1.0;
}

// Returns the colour of the surface with the detail applied: rgb, and alpha^2.
vec4 color_with_detail(const vec4 color, const DetailMeans detail) {
    if (DETAIL_COLORS == DETAIL_VARIES) {
        float alpha = DETAIL_IN_GLOSS ? color.a : mix(color.a, detail.color.a, detail.cover);
        return vec4(color.rgb * mix(vec3(1.0), detail.color.rgb * detail_color.rgb, detail.cover), alpha);
    }
    return mix(color, vec4(detail.color.rgb * detail_color.rgb, detail.color.a), detail.cover);
}

// Returns the roughness of a material with the spread of the detail's slopes and, if the detail varies the material, with the detail's own
// roughness. The lengths of the mean normals multiply (Chan 2018, eq. 34).
float alpha_with_detail(const float alpha, const vec2 mean_slope, const DetailMeans detail) {
    float spread = tail_mean_ratio(inversesqrt(max(normal_variance(mean_slope, detail.covariance), 1e-12)));
    float shortened = normal_shortening(LEADR_GGX_MACRO, alpha);
    shortened += spread - spread * shortened;
    if (DETAIL_COLORS == DETAIL_VARIES) {
        float own = detail.cover * normal_shortening(LEADR_GGX_MACRO, sqrt(detail.color.a));
        shortened += own - own * shortened;
    }
    return min(alpha_of_shortening(LEADR_GGX_MACRO, shortened), 1.0);
}

#endif
