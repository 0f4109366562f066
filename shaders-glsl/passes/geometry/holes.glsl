// Surfaces with holes. Under a pixel the map of their opacity tells which share of the surface is there; as large a share of the samples
// sees it, so that leaves and fences keep their coverage at every distance (crates/leadr-render/src/surfaces/material.rs makes the levels).
#ifndef LEADR_GEOMETRY_HOLES
#define LEADR_GEOMETRY_HOLES
#include "patch.glsl"

layout(set = 2, std430) readonly buffer Charts { TriangleCharts charts[]; };
layout(set = 2) uniform sampler2D opacity_map; // x: of a mask, with its edge at one half; y: share of the texel that is there

// Share of the surface that is there under a pixel. dx, dy: of the place, by x and y of the image.
float opacity_at(const uint index, const vec2 place, const vec2 dx, const vec2 dy) {
    PatchData data = patches[index];
    vec2 at = place;
    mat2 by_place = mat2(1.0);
    float whole = 1.0;
    if ((OBJECT.flags & FLAG_TRIANGLES) != 0u) {
        TriangleTexcoord texcoord = triangle_texcoord(data);
        if ((OBJECT.flags & FLAG_CHARTED) != 0u) {
            texcoord = charted_texcoord(charts[index], CHART_OPACITY);
        }
        by_place = texcoord.by_place;
        at = texcoord.first + by_place * place;
        float o = vertices[data.vertices.x].position.w;
        whole = o + (vertices[data.vertices.y].position.w - o) * place.x + (vertices[data.vertices.w].position.w - o) * place.y;
    } else if ((OBJECT.flags & FLAG_FLAT) == 0u) {
        PatchTexcoord texcoord = patch_texcoord(data, place.x, place.y);
        at = texcoord.at;
        by_place = mat2(texcoord.du, texcoord.dv);
    }
    vec2 size = vec2(textureSize(opacity_map, 0));
    mat2 texels = by_place * mat2(dx, dy);
    texels = mat2(texels[0] * size, texels[1] * size);
    // As wide as the texels under the pixel are many; below 0 texels are wider than pixels.
    float lod = 0.5 * log2(max(abs(determinant(texels)), 1e-12));
    float share = textureLod(opacity_map, at, max(lod, 0.0)).y;
    if ((OBJECT.flags & FLAG_MASK) == 0u) {
        return share * whole;
    }
    // Close by, the edge is as sharp as the pixels, wherever between the texels it runs.
    float mask = textureLod(opacity_map, at, 0.0).x * whole;
    vec2 gradient = vec2(textureLod(opacity_map, at + by_place * dx, 0.0).x - textureLod(opacity_map, at - by_place * dx, 0.0).x,
                         textureLod(opacity_map, at + by_place * dy, 0.0).x - textureLod(opacity_map, at - by_place * dy, 0.0).x) * 0.5;
    float near = clamp((mask - 0.5) / max(length(gradient), 1e-3) + 0.5, 0.0, 1.0);
    return mix(near, whole < 0.5 ? 0.0 : share, clamp(lod + 1.0, 0.0, 1.0));
}

uint mixed_bits(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

// The opacity from which on the first sample of this pixel sees this patch, 0 to 1: even over small squares of pixels (Jimenez 2014,
// interleaved gradient noise), shifted anew for every such square, patch and sample of the picture. So patches behind each other let
// pass what is the product of what each does.
float first_threshold(const uint index) {
    float noise = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
    uvec2 square = uvec2(gl_FragCoord.xy) / 4u;
    uint bits = mixed_bits(mixed_bits(index * 64u + OBJECT.number) ^ mixed_bits(square.x | square.y << 16) ^ floatBitsToUint(VIEW.eye.w));
    return fract(noise + float(bits >> 8) / 16777216.0);
}

// Which of a pixel's samples see a surface of this opacity, as bits: the thresholds of all are one `count`th apart.
uint seen_samples(const float opacity, const float first, const int count) {
    uint samples = 0u, turn = uint(first * 64.0);
    for (int i = 0; i < count; ++i) {
        float threshold = (float(i) + first) / float(count);
        samples |= opacity > threshold ? 1u << ((uint(i) + turn) % uint(count)) : 0u;
    }
    return samples;
}

#endif
