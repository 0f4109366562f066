#version 460
// Computes one step of a mip chain, as the mean of 2x2 texels on all layers.
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) readonly uniform image2DArray source;
layout(rgba32f) writeonly uniform image2DArray target;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(target)))) {
        return;
    }
    ivec3 from = ivec3(2 * at.xy, at.z);
    vec4 sum = imageLoad(source, from) + imageLoad(source, from + ivec3(1, 0, 0)) +
               imageLoad(source, from + ivec3(0, 1, 0)) + imageLoad(source, from + ivec3(1, 1, 0));
    imageStore(target, at, 0.25 * sum);
}
