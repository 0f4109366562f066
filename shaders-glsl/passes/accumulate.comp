#version 460
#extension GL_GOOGLE_include_directive : require

// Adds one jittered sample of the image, or a grid of edge samples in each pixel, to the running mean.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D sample_image;
layout(binding = 1, rgba32f) uniform image2D mean_image;
layout(binding = 2) uniform sampler2D pixel_image; // what the pixel's surface was shaded as
layout(push_constant) uniform Weight { float weight; } push; // 1 / (samples so far)

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean_image);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec4 own = texelFetch(pixel_image, pixel, 0);
    int grid = textureSize(sample_image, 0).x / size.x;
    // Sums of differences: where all samples see the pixel's surface, its own value is kept to the bit.
    vec4 others = vec4(0.0);
    for (int i = 0; i < grid * grid; ++i) {
        vec4 value = texelFetch(sample_image, pixel * grid + ivec2(i % grid, i / grid), 0);
        others += value.a < 0.0 ? vec4(0.0) : value - own; // see edges.glsl
    }
    vec4 value = own + others / float(grid * grid);
    vec4 mean = push.weight >= 1.0 ? vec4(0.0) : imageLoad(mean_image, pixel);
    imageStore(mean_image, pixel, mean + (value - mean) * push.weight);
}
