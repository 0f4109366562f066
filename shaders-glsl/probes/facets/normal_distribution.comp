#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/normal_distribution.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 1;
    float t = next();
    at = gl_GlobalInvocationID.x * 5;
    put(normal_pdf(t));
    put(normal_tail_mean(t));
    put(normal_cdf(t));
    ClampedLine line = clamped_line(t);
    put(line.lean);
    put(line.front);
}
