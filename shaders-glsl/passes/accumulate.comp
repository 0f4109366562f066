#version 460
#extension GL_GOOGLE_include_directive : require

// Adds one jittered sample of the picture to the running mean.
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool EDGES = false; // the sample has edge samples (join.comp)

uniform sampler2D sample_image; // radiance of the pixels' own surfaces
layout(rgba32f) uniform image2D mean_image;
uniform sampler2D others; // sum of the edge samples that see other surfaces
uniform sampler2D shares; // x: number of edge samples that see the pixel's own surface
layout(push_constant) uniform Weights {
    float weight;       // 1 / number of samples so far, this one included
    float edge_samples; // per pixel
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean_image);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec4 value = texelFetch(sample_image, pixel, 0);
    if (EDGES) {
        // A share of exactly one leaves the value unchanged to the bit.
        value *= texelFetch(shares, pixel, 0).x / push.edge_samples;
        value += texelFetch(others, pixel, 0) / push.edge_samples;
    }
    vec4 mean = push.weight >= 1.0 ? vec4(0.0) : imageLoad(mean_image, pixel);
    imageStore(mean_image, pixel, mean + (value - mean) * push.weight);
}
