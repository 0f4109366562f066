#version 460
#extension GL_GOOGLE_include_directive : require
// Marks where an edge sample sees the surface that its pixel is shaded by, so that nothing filters and shades it again.
#include "edges.glsl"
#include "leadr/frame.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D pixel_surface; // what the pixel's own sample sees: geometry.frag
layout(binding = 1) uniform usampler2D pixel_tangent;
layout(binding = 2) uniform sampler2D pixel_depth;
layout(binding = 3, rgba32ui) uniform uimage2D edge_surface; // what the edge sample sees
layout(binding = 4) uniform usampler2D edge_tangent;
layout(binding = 5) uniform sampler2D edge_depth;

// Rays as in read_gbuffer; x and y are the same for both samples.
layout(push_constant, std430) uniform EdgeRays {
    vec4 x;
    vec4 y;
    vec4 pixel; // w: near plane
    vec4 edge;
} rays;

const uint OBJECT_AND_INSIDE = 0xff000000u;
const float SAME_NORMAL = 0.9; // cosine of the largest turn of the displacement direction on one surface

vec3 across(ivec2 pixel, ivec2 size) {
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    return ndc.x * rays.x.xyz + ndc.y * rays.y.xyz;
}

void main() {
    ivec2 edge = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(edge_surface);
    if (any(greaterThanEqual(edge, size))) {
        return;
    }
    // Edge samples come in grids inside each pixel.
    ivec2 pixels = textureSize(pixel_surface, 0), pixel = edge * pixels / size;
    uint object = texelFetch(pixel_surface, pixel, 0).x & OBJECT_AND_INSIDE;
    bool same = object == (imageLoad(edge_surface, edge).x & OBJECT_AND_INSIDE);
    if (same && object != 0u) {
        float pixel_distance = rays.pixel.w / texelFetch(pixel_depth, pixel, 0).x;
        float edge_distance = rays.pixel.w / texelFetch(edge_depth, edge, 0).x;
        vec3 apart = edge_distance * (rays.edge.xyz + across(edge, size))
                   - pixel_distance * (rays.pixel.xyz + across(pixel, pixels));
        vec3 a = octahedral_decode(unpackSnorm2x16(texelFetch(pixel_tangent, pixel, 0).x));
        vec3 b = octahedral_decode(unpackSnorm2x16(texelFetch(edge_tangent, edge, 0).x));
        // Two points of one sphere are apart across their mean normal, however grazing the view. What stands out of it by less
        // than a pixel is too small to be told apart.
        float width = 2.0 * length(rays.y.xyz) / float(pixels.y) * pixel_distance;
        same = dot(a, b) > SAME_NORMAL && abs(dot(apart, normalize(a + b))) < width;
    }
    if (same) {
        imageStore(edge_surface, edge, uvec4(SURFACE_OF_THE_PIXEL, 0u, 0u, 0u));
    }
}
