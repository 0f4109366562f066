#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/materials/diffuse_models.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 10;
    vec3 wo = next3();
    vec3 wi = next3();
    float alpha = next();
    vec3 albedo = next3();
    at = gl_GlobalInvocationID.x * 42;
    for (int model = LEADR_DIFFUSE_LAMBERT; model <= LEADR_DIFFUSE_CONSERVING; ++model) {
        put(diffuse_value(model, wo, wi, alpha, albedo));
        put(diffuse_model_albedo(model, wo.z, alpha, albedo));
    }
}
