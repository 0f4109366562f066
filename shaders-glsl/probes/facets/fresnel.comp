#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/fresnel.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 5;
    vec3 f0 = next3();
    float cosine = next();
    float eta = next();
    at = gl_GlobalInvocationID.x * 7;
    put(fresnel_schlick(f0, cosine));
    put(fresnel_dielectric(cosine, eta));
    put(fresnel_edge_tint(f0, vec3(4.0, 1.0, 0.0), cosine));
}
