#version 460
#extension GL_GOOGLE_include_directive : require
// Marks the edge samples on the same surface as their pixel, which are not shaded again. Where the pixel's footprint is not small compared
// with a patch, these samples are filtered and joined (join.comp).
#define LEADR_EDGE_RAYS
#include "edges.glsl"
#include "../gbuffer.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler2D pixel_surface; // surface of the pixel's own sample (geometry.frag)
uniform usampler2D pixel_slopes;  // G-buffer of the pixel's own sample
uniform sampler2D pixel_depth;
layout(rgba32ui) uniform uimage2D edge_surface; // surface of the edge sample
uniform sampler2D edge_depth;
uniform usampler2D pixel_filtered;

void main() {
    ivec2 size = imageSize(edge_surface), pixels = textureSize(pixel_surface, 0);
    int grid = size.x / pixels.x;
    ivec2 edge = rays.area.xy * grid + ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(edge, rays.area.zw * grid))) {
        return;
    }
    // Each pixel contains a grid of edge samples.
    ivec2 pixel = edge / grid;
    uint object = texelFetch(pixel_surface, pixel, 0).x & (OBJECT_BITS | INSIDE);
    uvec4 seen = imageLoad(edge_surface, edge);
    bool same = object == (seen.x & (OBJECT_BITS | INSIDE));
    if (same && object != 0u) {
        float pixel_distance = rays.pixel.w / texelFetch(pixel_depth, pixel, 0).x;
        float edge_distance = rays.pixel.w / texelFetch(edge_depth, edge, 0).x;
        vec3 apart = edge_distance * (rays.edge.xyz + ray_across(edge, size))
                   - pixel_distance * (rays.pixel.xyz + ray_across(pixel, pixels));
        vec3 a = octahedral_decode(unpackSnorm2x16(texelFetch(pixel_slopes, pixel, 0).x));
        vec3 b = octahedral_decode(unpackSnorm2x16(seen.w));
        // Two points of one smooth surface differ in directions orthogonal to their mean normal, even at grazing views. A difference along
        // the normal of less than a pixel is ignored.
        float width = 2.0 * length(rays.y.xyz) / float(pixels.y) * pixel_distance;
        same = dot(a, b) > SAME_NORMAL && abs(dot(apart, normalize(a + b))) < width;
    }
    if (same) {
        bool joined = object != 0u && joined_part_of(texelFetch(pixel_filtered, pixel, 0).xy) > 0.0;
        imageStore(edge_surface, edge, joined ? uvec4(seen.x | OF_THE_PIXEL, seen.yzw) : uvec4(SURFACE_OF_THE_PIXEL, uvec3(0u)));
    }
}
