#version 460
// Keeps the mean of the samples from becoming negative.
layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f) uniform image2D mean_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(mean_image)))) {
        imageStore(mean_image, pixel, max(imageLoad(mean_image, pixel), vec4(0.0)));
    }
}
