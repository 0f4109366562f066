#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/transmission.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 13;
    vec3 w = next3();
    vec3 facet = next3();
    vec3 n = next3();
    float eta = next();
    float variance = next();
    float alpha = next();
    float length = next();
    at = gl_GlobalInvocationID.x * 12;
    float cosine = dot(w, facet);
    put(refracted_cosine(cosine, eta));
    put(refracted(w, facet, eta));
    put(passed_solid(w, facet, n, eta));
    put(refracted_variance(variance, cosine, eta));
    put(thin_variance(alpha, cosine));
    put(attenuation(vec3(0.0, 1.0, 5.0), length));
}
