#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/shading.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float roughness = next();
    at = gl_GlobalInvocationID.x * 6;
    put(leadr_light(LeadrSurface(m, S, roughness, vec3(0.8, 0.5, 0.2), vec3(0.0)), wo, wi));
    put(leadr_light(LeadrSurface(m, S, roughness, vec3(0.0), vec3(0.04, 0.5, 1.0)), wo, wi));
}
