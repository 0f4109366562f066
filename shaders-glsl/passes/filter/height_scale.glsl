// The height scale under a pixel.
#ifndef LEADR_FILTER_HEIGHT_SCALE
#define LEADR_FILTER_HEIGHT_SCALE
#include "../geometry/height_scale.glsl"

struct HeightScale {
    float mean;
    float variance;
    vec2 by_uv; // derivatives of the mean by position on the patch
};

const HeightScale FULL_HEIGHT_SCALE = HeightScale(1.0, 0.0, vec2(0.0));

// Returns the derivatives of the first channel of a map, as differences over one texel of a level.
vec2 gradient_of(sampler2D map, const vec2 at, const float lod) {
    vec2 apart = exp2(lod) / vec2(textureSize(map, 0));
    vec2 s = vec2(0.5 * apart.x, 0.0), t = vec2(0.0, 0.5 * apart.y);
    return vec2(textureLod(map, at + s, lod).x - textureLod(map, at - s, lod).x,
                textureLod(map, at + t, lod).x - textureLod(map, at - t, lod).x) / apart;
}

// Filters the height scale. The values of vertices vary slowly, so only the map has a variance.
HeightScale filter_height_scale(const uint index, const vec2 patch_uv, const vec2 texcoord, const mat2 texcoord_by_uv, const mat2 across) {
    HeightScale scale = FULL_HEIGHT_SCALE;
    if (SCALED_BY_VERTEX) {
        PatchData data = patches[index];
        vec4 corners = corner_height_scales(data);
        vec2 at = position_on_patch(data, patch_uv);
        if (TRIANGLES) {
            scale.mean = triangle_height_scale(corners, at);
            scale.by_uv = vec2(corners.y, corners.w) - corners.x;
        } else {
            scale.mean = quad_height_scale(corners, at);
            scale.by_uv = quad_height_scale_by_uv(corners, at);
            if (FLAT) {
                PatchTexcoord corner = patch_texcoord(data, 0.0, 0.0);
                scale.by_uv *= inverse(mat2(corner.du, corner.dv));
            }
        }
    }
    if (SCALED_BY_MAP) {
        vec2 size = vec2(textureSize(coarse_a, 0)), here = height_scale_texcoord(texcoord);
        mat2 by_uv = mat2(OBJECT.scale_linear.xy, OBJECT.scale_linear.zw) * texcoord_by_uv, texels = by_uv * across;
        Footprint wide = detail_footprint(texels[0] * size, texels[1] * size, OF_IMAGE);
        vec2 mean = vec2(0.0);
        float square = 0.0;
        for (int i = 0; i < wide.taps; ++i) {
            vec2 of_tap = textureLod(coarse_a, here + tap(wide, i) / size, wide.lod).xy;
            mean += of_tap;
            square += of_tap.x * of_tap.x;
        }
        mean /= float(wide.taps);
        float variance = mean.y + max(square / float(wide.taps) - mean.x * mean.x, 0.0);
        vec2 change = gradient_of(coarse_a, here, wide.lod);
        scale.by_uv = scale.by_uv * mean.x + scale.mean * (change * by_uv);
        scale.variance = scale.mean * scale.mean * variance;
        scale.mean *= mean.x;
    }
    return scale;
}

#endif
