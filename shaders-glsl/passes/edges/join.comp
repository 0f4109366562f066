#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Joins the edge samples of each pixel. Samples of other surfaces add their radiance. Samples of the pixel's own surface add slope
// statistics, material and visibility of the sun. The joined values replace the values of the pixel's own sample where the footprint is not
// small compared with a patch.
#define LEADR_EDGE_RAYS
#include "edges.glsl"
#include "../gbuffer.glsl"
#include "../technique.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"
#include "leadr/slopes/rotation.glsl"
#include "../shade/sun.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler2D edge_surface;
uniform sampler2D edge_radiance;
uniform usampler2D edge_slopes;    // the G-buffer of the edge samples
uniform usampler2D edge_material;
uniform usampler2D edge_joined;    // area of the surface, relief of the object
layout(rgba32f) uniform image2D others;   // sum of the radiance and coverage of other surfaces
layout(rgba32f) uniform image2D shares;   // samples on the pixel's surface; of the joined ones: area, number, fraction lit by the first sun
layout(rgba32f) uniform image2D more_suns; // fraction lit by each of the other suns
uniform usampler2D pixel_surface; // the G-buffer of the pixels
layout(rgba32ui) uniform uimage2D slopes; // the G-buffer of the pixels
layout(rgba32ui) uniform uimage2D material;
uniform sampler2D edge_depth;

layout(constant_id = 7) const int SHADOW_MAPS = 1; // number of suns with shadows

// Near silhouettes, the surface area within a sample grows, and bumps hide most of it. This smallest cosine limits the area.
const float LEAST_COSINE = 0.1;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), pixels = imageSize(others);
    if (any(greaterThanEqual(pixel, pixels))) {
        return;
    }
    bool first = rays.edge.w == 0.0;
    vec4 sum = first ? vec4(0.0) : imageLoad(others, pixel);
    vec4 share = first ? vec4(0.0) : imageLoad(shares, pixel);
    vec4 more = first || SHADOW_MAPS < 2 ? vec4(0.0) : imageLoad(more_suns, pixel);
    // The weight of the pixel's own sample, in edge samples, which is zero except where joining begins.
    float part = joined_part_of(texelFetch(pixel_surface, pixel, 0).xy);
    float own_weight = rays.x.w * (1.0 / max(part, 1e-4) - 1.0);
    if (first) {
        share.y = own_weight;
    }
    ivec2 edges = textureSize(edge_surface, 0);
    int grid = edges.x / pixels.x;
    if (any(lessThan(pixel, rays.area.xy)) || any(greaterThanEqual(pixel, rays.area.zw))) {
        imageStore(others, pixel, sum);
        imageStore(shares, pixel, share + vec4(float(grid * grid), 0.0, 0.0, 0.0));
        if (SHADOW_MAPS > 1) {
            imageStore(more_suns, pixel, more);
        }
        return;
    }
    uvec4 own = imageLoad(slopes, pixel), own_material = imageLoad(material, pixel);
    Frame to = frame_about(octahedral_decode(unpackSnorm2x16(own.x)));
    SlopePart whole = SlopePart(mean_slope_of(own), covariance_of(own, own_material), share.y);
    vec4 materials = vec4(0.0);
    // The solid angle of an edge sample.
    float cell = 4.0 * length(cross(rays.x.xyz, rays.y.xyz)) / (float(edges.x) * float(edges.y) * dot(rays.pixel.xyz, rays.pixel.xyz));
    float joined = share.z, sunlit = share.w;
    for (int i = 0; i < grid * grid; ++i) {
        ivec2 at = pixel * grid + ivec2(i % grid, i / grid);
        uint word = texelFetch(edge_surface, at, 0).x;
        bool of_the_pixel = (word & OF_THE_PIXEL) != 0u;
        if (of_the_pixel) {
            uvec4 seen = texelFetch(edge_slopes, at, 0), seen_material = texelFetch(edge_material, at, 0);
            vec2 mean = mean_slope_of(seen);
            vec2 area_relief = uintBitsToFloat(texelFetch(edge_joined, at, 0).xy);
            Frame from = frame_about(octahedral_decode(unpackSnorm2x16(seen.x)));
            mat3 rotation = mat3(to_frame(to, from.x), to_frame(to, from.y), to_frame(to, from.z));
            SlopePart part = rotate_slopes(rotation, mean, covariance_of(seen, seen_material));
            // Bumps that face the viewer fill more samples than others, so samples are weighted by their surface area.
            vec3 to_sample = (rays.edge.xyz + ray_across(at, edges)) * (rays.pixel.w / texelFetch(edge_depth, at, 0).x);
            part.area *= clamp(area_relief.x / (cell * dot(to_sample, to_sample)), 1e-3, 1.0 / LEAST_COSINE);
            whole = join_slopes(whole, part);
            vec4 seen_part = material_of(seen_material);
            materials += vec4(seen_part.rgb, seen_part.a * seen_part.a);
            joined += 1.0;
            if (SHADOW_MAPS > 0) {
                vec3 position = lighting.camera_position.xyz + to_sample;
                vec3 mesonormal = from_frame(from, normalize(vec3(-mean, 1.0)));
                float width = edge_shadow_width(position, area_relief.y);
                sunlit += sun_visibility(0, position, mesonormal, from.z, float(grid) * width);
                for (int k = 1; k < min(SHADOW_MAPS, MAX_SUNS); ++k) {
                    more[k - 1] += sun_visibility(k, position, mesonormal, from.z, float(grid) * width);
                }
            }
        }
        if (of_the_pixel || word == SURFACE_OF_THE_PIXEL) {
            share.x += 1.0;
        } else {
            sum += texelFetch(edge_radiance, at, 0);
        }
    }
    if (joined > share.z) {
        vec3 covariance = clamp_covariance(technique_covariance(whole.covariance, vec3(0.0)));
        vec4 own_part = material_of(own_material);
        own_part.a *= own_part.a; // Roughness is averaged as a variance.
        materials = (own_part * (own_weight + share.z) + materials) / (own_weight + joined);
        materials.a = sqrt(materials.a);
        imageStore(slopes, pixel, pack_slopes(own.x, whole.mean, covariance));
        imageStore(material, pixel, pack_material(materials, covariance));
        share.yzw = vec3(whole.area, joined, sunlit);
    }
    if (SHADOW_MAPS > 1) {
        imageStore(more_suns, pixel, more);
    }
    imageStore(others, pixel, sum);
    imageStore(shares, pixel, share);
}
