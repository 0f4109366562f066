#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/shortened_normals.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 5;
    float alpha = next();
    float other = next();
    float one_minus_length = next();
    float base = next();
    float detail = next();
    at = gl_GlobalInvocationID.x * 18;
    for (int shortening = 0; shortening < 4; shortening++) {
        put(normal_shortening(shortening, alpha));
        put(normal_length(shortening, alpha));
        put(alpha_of_shortening(shortening, one_minus_length));
        put(combine_alpha(shortening, alpha, other));
    }
    put(ggx_alpha_of_shortening_fit(one_minus_length));
    put(chan_combine_gloss(base, detail));
}
