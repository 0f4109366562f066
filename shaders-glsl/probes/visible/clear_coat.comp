#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/clear_coat.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 15;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = clamp_covariance(next3());
    float weight = next();
    vec3 reflectances = next3();
    vec3 wi = next3();
    bool exact = reflectances.z > 0.5;
    at = gl_GlobalInvocationID.x * 11;
    put(coat_reflectance(wo, m, S, weight, exact));
    put(coat_facet_reflectance(reflectances.x, weight, exact));
    put(coat_average(weight, exact));
    put(coated_base(reflectances.x, reflectances.y, reflectances.z, vec3(0.0, 0.5, 0.9)));
    put(coat_reflectances(wo, wi, m, S, weight, exact));
    put(coat_bands(weight, exact));
}
