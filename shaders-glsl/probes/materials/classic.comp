#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/materials/classic.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 7;
    float alpha = next();
    float cosine = next();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 7;
    float exponent = blinn_phong_exponent(alpha);
    float variance = normal_variance(m, S);
    float filtered = toksvig_variance(variance);
    put(exponent);
    put(blinn_phong_variance(exponent));
    put(blinn_phong_ndf(cosine, exponent));
    put(variance);
    put(filtered);
    put(toksvig_exponent(exponent, filtered));
    put(lobe_lod(variance, 256.0));
}
