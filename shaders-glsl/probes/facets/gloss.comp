#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/gloss.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 2;
    float gloss = next();
    float alpha = next();
    at = gl_GlobalInvocationID.x * 8;
    put(gloss_alpha(gloss, LEADR_GLOSS_ADVANCED_WARFARE));
    put(gloss_alpha(gloss, LEADR_GLOSS_WWII));
    put(gloss_alpha(gloss, LEADR_GLOSS_BLINN_PHONG));
    put(perceptual_gloss_alpha(gloss));
    put(alpha_gloss(alpha, LEADR_GLOSS_ADVANCED_WARFARE));
    put(alpha_gloss(alpha, LEADR_GLOSS_WWII));
    put(alpha_gloss(alpha, LEADR_GLOSS_BLINN_PHONG));
    put(perceptual_alpha_gloss(alpha));
}
