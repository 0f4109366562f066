#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// Adds one jittered sample of the image to the running mean.
layout(local_size_x = 8, local_size_y = 8) in;

#include "msaa.glsl"

layout(constant_id = 0) const bool EDGES = false; // whether the sample has edge samples (join.comp)
layout(constant_id = 1) const int MSAA = 1;       // number of geometry samples in each pixel (msaa.comp)

uniform sampler2D sample_image; // radiance of each pixel's own surface
layout(rgba32f) uniform image2D mean_image;
uniform sampler2D others; // sum of the edge samples that hit other surfaces
uniform usampler2D others_of_pixels; // slots of the other surfaces of a multisampled pixel
uniform sampler2D shares; // x: number of edge samples on the pixel's own surface
layout(push_constant) uniform Weights {
    float weight;       // 1 / number of samples so far, including this one
    float edge_samples; // number of edge samples per pixel
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean_image);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec4 value = texelFetch(sample_image, pixel, 0);
    if (MSAA > 1) {
        uint listed = texelFetch(others_of_pixels, pixel, 0).x;
        int height = textureSize(sample_image, 0).y, slot = first_slot(listed), own = MSAA;
        vec4 sum = vec4(0.0);
        [[unroll]] for (int i = 0; i < min(MSAA - 1, MOST_OTHERS); ++i) {
            int covered = samples_of(listed, i);
            // Slots without samples contain invalid radiance.
            if (covered > 0) {
                sum += float(covered) * texelFetch(sample_image, slot_texel(pixel, slot + i, height), 0);
            }
            own -= covered;
        }
        value = (value * float(own) + sum) / float(MSAA);
    }
    if (EDGES) {
        // A share of exactly one leaves the value unchanged to the bit.
        value *= texelFetch(shares, pixel, 0).x / push.edge_samples;
        value += texelFetch(others, pixel, 0) / push.edge_samples;
    }
    vec4 mean = push.weight >= 1.0 ? vec4(0.0) : imageLoad(mean_image, pixel);
    imageStore(mean_image, pixel, mean + (value - mean) * push.weight);
}
