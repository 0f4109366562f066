#version 460
#extension GL_GOOGLE_include_directive : require
// Like geometry.frag, but for alpha-masked surfaces, where some samples may show the surface behind.
#include "seen.glsl"
#include "cutout.glsl"

layout(constant_id = 3) const int SAMPLES = 1; // number of samples per pixel

void main() {
    float opacity = opacity_at(in_patch, in_patch_uv, dFdx(in_patch_uv), dFdy(in_patch_uv));
    // The mask is written for single samples too, because a declared but unwritten mask hides all samples.
    uint samples = seen_samples(opacity, first_threshold(in_patch), SAMPLES);
    gl_SampleMask[0] = int(samples);
    if (samples == 0u) {
        discard;
    }
    write_seen();
}
