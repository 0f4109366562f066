// Draws alpha-masked surfaces. The mean opacity under a pixel gives the fraction of its samples that show the surface, so that leaves and
// fences keep their coverage at every distance (crates/leadr-render/src/surfaces/material.rs makes the levels).
#ifndef LEADR_GEOMETRY_CUTOUT
#define LEADR_GEOMETRY_CUTOUT
#include "patch.glsl"

layout(set = 2, std430) readonly buffer Charts { TriangleCharts charts[]; };
layout(set = 2) uniform sampler2D opacity_map; // x: alpha mask, whose edge is at one half; y: coverage of the texel

// Returns the coverage of the surface under a pixel. dx and dy are the derivatives of the position by x and y of the image.
float opacity_at(const uint index, const vec2 patch_uv, const vec2 dx, const vec2 dy) {
    PatchData data = patches[index];
    vec2 at = patch_uv;
    mat2 by_uv = mat2(1.0);
    float whole = 1.0;
    if ((OBJECT.flags & FLAG_TRIANGLES) != 0u) {
        TriangleTexcoord texcoord = triangle_texcoord(data);
        if ((OBJECT.flags & FLAG_CHARTED) != 0u) {
            texcoord = charted_texcoord(charts[index], CHART_OPACITY);
        }
        by_uv = texcoord.by_uv;
        at = texcoord.first + by_uv * patch_uv;
        float o = vertices[data.vertices.x].position.w;
        whole = o + (vertices[data.vertices.y].position.w - o) * patch_uv.x + (vertices[data.vertices.w].position.w - o) * patch_uv.y;
    } else if ((OBJECT.flags & FLAG_FLAT) == 0u) {
        PatchTexcoord texcoord = patch_texcoord(data, patch_uv.x, patch_uv.y);
        at = texcoord.at;
        by_uv = mat2(texcoord.du, texcoord.dv);
    }
    vec2 size = vec2(textureSize(opacity_map, 0));
    mat2 texels = by_uv * mat2(dx, dy);
    texels = mat2(texels[0] * size, texels[1] * size);
    // The level follows from the number of texels under the pixel. Below 0, texels are wider than pixels.
    float lod = 0.5 * log2(max(abs(determinant(texels)), 1e-12));
    float share = textureLod(opacity_map, at, max(lod, 0.0)).y;
    if ((OBJECT.flags & FLAG_MASK) == 0u) {
        return share * whole;
    }
    // Under magnification, the edge of the mask is as sharp as a pixel, even between texels.
    float mask = textureLod(opacity_map, at, 0.0).x * whole;
    vec2 gradient = vec2(textureLod(opacity_map, at + by_uv * dx, 0.0).x - textureLod(opacity_map, at - by_uv * dx, 0.0).x,
                         textureLod(opacity_map, at + by_uv * dy, 0.0).x - textureLod(opacity_map, at - by_uv * dy, 0.0).x) * 0.5;
    float near = clamp((mask - 0.5) / max(length(gradient), 1e-3) + 0.5, 0.0, 1.0);
    return mix(near, whole < 0.5 ? 0.0 : share, clamp(lod + 1.0, 0.0, 1.0));
}

uint mixed_bits(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

// Returns the smallest opacity, 0 to 1, at which the first sample of this pixel shows this patch. The values are evenly distributed over
// small squares of pixels (Jimenez 2014, interleaved gradient noise). Each square, patch and sample of the image has a shift of its own, so
// the transparencies of overlapping patches multiply.
float first_threshold(const uint index) {
    float noise = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
    uvec2 square = uvec2(gl_FragCoord.xy) / 4u;
    uint bits = mixed_bits(mixed_bits(index * 64u + OBJECT.number) ^ mixed_bits(square.x | square.y << 16) ^ floatBitsToUint(VIEW.eye.w));
    return fract(noise + float(bits >> 8) / 16777216.0);
}

// Returns the samples of a pixel that show a surface of this opacity, as bits. The thresholds of consecutive samples differ by 1 / count.
uint seen_samples(const float opacity, const float first, const int count) {
    uint samples = 0u, first_sample = uint(first * 64.0);
    for (int i = 0; i < count; ++i) {
        float threshold = (float(i) + first) / float(count);
        samples |= opacity > threshold ? 1u << ((uint(i) + first_sample) % uint(count)) : 0u;
    }
    return samples;
}

#endif
