#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/facets/complex_index.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 5;
    vec3 f0 = next3();
    float cosine = next();
    float eta = next();
    at = gl_GlobalInvocationID.x * 13;
    put(fresnel_schlick(f0, cosine));
    put(fresnel_dielectric(cosine, eta));
    vec3 edge_tint = vec3(4.0, 1.0, 0.0);
    put(fresnel_edge_tint(f0, edge_tint, cosine));
    ComplexIndex index = complex_index(f0, edge_tint);
    put(fresnel_exact(f0, index, cosine));
    put(average_deviation(f0, index));
}
