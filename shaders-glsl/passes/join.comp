#version 460
#extension GL_GOOGLE_include_directive : require
// Joins the edge samples of each pixel: the radiance of those that see other surfaces, and, where the pixel's own surface is
// more than one patch knows, the slope statistics and materials of those that see it, which take the place of the pixel's,
// and the sun's visibility from them.
#define LEADR_EDGE_RAYS
#include "edges.glsl"
#include "technique.glsl"
#include "visible.glsl"
#include "leadr/frame.glsl"
#include "leadr/slope_turn.glsl"
#include "shade/sun.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D edge_surface;
layout(binding = 1) uniform sampler2D edge_radiance;
layout(binding = 2) uniform sampler2D edge_frame;      // the g-buffer of the edge samples (shade/gbuffer.glsl)
layout(binding = 3) uniform sampler2D edge_covariance; // w: area
layout(binding = 4) uniform sampler2D edge_material;
layout(binding = 6, rgba32f) uniform image2D others;   // sum of the radiance and coverage of other surfaces
layout(binding = 7, rgba32f) uniform image2D shares;   // samples on the pixel's surface; area, number and sunlit part of those joined
layout(binding = 9, rgba32f) uniform image2D frame;    // the g-buffer of the pixels
layout(binding = 10, rgba32f) uniform image2D covariance;
layout(binding = 11, rgba16f) uniform image2D material;
layout(binding = 12) uniform sampler2D edge_depth;
layout(binding = 13) uniform sampler2D edge_scalars;   // w: relief

layout(constant_id = 7) const bool SUN_SHADOWS = true;

// A surface seen edge-on fills a sample with ever more of itself, most of which its bumps hide: this cosine bounds how much.
const float LEAST_COSINE = 0.1;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), pixels = imageSize(others);
    if (any(greaterThanEqual(pixel, pixels))) {
        return;
    }
    bool first = rays.edge.w == 0.0;
    vec4 sum = first ? vec4(0.0) : imageLoad(others, pixel);
    vec4 share = first ? vec4(0.0) : imageLoad(shares, pixel);
    ivec2 edges = textureSize(edge_surface, 0);
    int grid = edges.x / pixels.x;
    if (any(lessThan(pixel, rays.area.xy)) || any(greaterThanEqual(pixel, rays.area.zw))) {
        imageStore(others, pixel, sum);
        imageStore(shares, pixel, share + vec4(float(grid * grid), 0.0, 0.0, 0.0));
        return;
    }
    vec4 own = imageLoad(frame, pixel), own_covariance = imageLoad(covariance, pixel), own_material = vec4(0.0);
    vec3 z = octahedral_decode(own.xy);
    Frame to = frame_about(z);
    SlopePart whole = SlopePart(own.zw, own_covariance.xyz, share.y);
    // Solid angle of an edge sample.
    float cell = 4.0 * length(cross(rays.x.xyz, rays.y.xyz)) / (float(edges.x) * float(edges.y) * dot(rays.pixel.xyz, rays.pixel.xyz));
    float joined = share.z, sunlit = share.w;
    for (int i = 0; i < grid * grid; ++i) {
        ivec2 at = pixel * grid + ivec2(i % grid, i / grid);
        uint word = texelFetch(edge_surface, at, 0).x;
        bool of_the_pixel = (word & OF_THE_PIXEL) != 0u;
        if (of_the_pixel) {
            vec4 seen = texelFetch(edge_frame, at, 0);
            vec3 n = octahedral_decode(seen.xy);
            Frame from = frame_about(n);
            mat3 turn = mat3(to_frame(to, from.x), to_frame(to, from.y), to_frame(to, from.z));
            vec4 statistics = texelFetch(edge_covariance, at, 0);
            SlopePart part = turn_slopes(turn, seen.zw, statistics.xyz);
            // Bumps that face the viewer fill more samples than others; what counts is how much of the surface is in them.
            vec3 to_sample = (rays.edge.xyz + ray_across(at, edges)) * (rays.pixel.w / texelFetch(edge_depth, at, 0).x);
            part.area *= clamp(statistics.w / (cell * dot(to_sample, to_sample)), 1e-3, 1.0 / LEAST_COSINE);
            whole = join_slopes(whole, part);
            own_material += texelFetch(edge_material, at, 0);
            joined += 1.0;
            if (SUN_SHADOWS) {
                vec3 position = lighting.camera_position.xyz + to_sample;
                vec3 mesonormal = from_frame(from, normalize(vec3(-seen.zw, 1.0)));
                float width = edge_shadow_width(position, texelFetch(edge_scalars, at, 0).w);
                sunlit += sun_visibility(position, mesonormal, float(grid) * width);
            }
        }
        if (of_the_pixel || word == SURFACE_OF_THE_PIXEL) {
            share.x += 1.0;
        } else {
            sum += texelFetch(edge_radiance, at, 0);
        }
    }
    if (joined > share.z) {
        if (!USES_COVARIANCE) {
            whole.covariance = vec3(0.0);
        } else if (TECHNIQUE == TECHNIQUE_CLEAN) {
            whole.covariance = vec3(vec2(0.5 * (whole.covariance.x + whole.covariance.y)), 0.0);
        }
        imageStore(frame, pixel, vec4(own.xy, whole.mean));
        imageStore(covariance, pixel, vec4(clamp_covariance(whole.covariance), own_covariance.w));
        vec4 before = imageLoad(material, pixel);
        imageStore(material, pixel, (before * share.z + own_material) / joined);
        share.yzw = vec3(whole.area, joined, sunlit);
    }
    imageStore(others, pixel, sum);
    imageStore(shares, pixel, share);
}
