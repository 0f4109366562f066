#version 460
#extension GL_GOOGLE_include_directive : require
layout(std430) readonly buffer Fits { float fits[]; };
#define LEADR_FITTED_WORD(i) fits[i]
#include "leadr/materials/fitted.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec3 wi = next3();
    float stretch = next();
    float cosine = next();
    at = gl_GlobalInvocationID.x * 8;
    put(fitted_ndf(0u, wi, stretch));
    put(fitted_area(0u, wo, stretch));
    put(fitted_fresnel(0u, cosine));
    put(fitted_specular(0u, wo, wi, stretch));
    float area = fitted_lobes_area(0u, wo, stretch);
    put(area);
    put(fitted_lobes_density(0u, wo, wi, area, stretch));
}
