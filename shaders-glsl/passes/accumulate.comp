#version 460

// Adds one jittered sample of the image to the running mean.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D sample_image;
layout(binding = 1, rgba32f) uniform image2D mean_image;
layout(binding = 2) uniform sampler2D pixel_image; // of edge sample 0
layout(push_constant) uniform Weight { float weight; } push; // 1 / (samples so far)

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(mean_image)))) {
        return;
    }
    vec4 value = texelFetch(sample_image, pixel, 0);
    if (value.a < 0.0) { // the pixel's own surface: see edges.comp
        value = texelFetch(pixel_image, pixel, 0);
    }
    vec4 mean = push.weight >= 1.0 ? vec4(0.0) : imageLoad(mean_image, pixel);
    imageStore(mean_image, pixel, mean + (value - mean) * push.weight);
}
