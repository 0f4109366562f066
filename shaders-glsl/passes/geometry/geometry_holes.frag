#version 460
#extension GL_GOOGLE_include_directive : require
// The same of a surface with holes, through which samples see what lies behind.
#include "seen.glsl"
#include "holes.glsl"

layout(constant_id = 3) const int SAMPLES = 1; // of each pixel

void main() {
    float opacity = opacity_at(in_patch, in_place, dFdx(in_place), dFdy(in_place));
    // Of single samples as well: a mask that is declared and not written hides them all.
    uint samples = seen_samples(opacity, first_threshold(in_patch), SAMPLES);
    gl_SampleMask[0] = int(samples);
    if (samples == 0u) {
        discard;
    }
    write_seen();
}
