#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/materials/multiscattering.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 22;
    vec3 wo = next3();
    vec3 wi = next3();
    float alpha = next();
    vec3 f0 = next3();
    vec3 albedo = next3();
    vec3 o = next3();
    vec3 i = next3();
    vec3 average = next3();
    FacetBounces bounces = facet_bounces(alpha), lossy = facet_bounces_lossy(alpha);
    at = gl_GlobalInvocationID.x * 23;
    put(multiscattering_diffuse(wo, wi, bounces, f0, albedo, o, i, average));
    put(multiscattering_diffuse(wo, wi, lossy, f0, albedo, o, i, average));
    put(multiscattering_albedo(bounces, albedo, o));
    put(facet_albedo(bounces, albedo));
    put(facet_diffuse(f0.x, wo.z, wi.z));
    put(chan_diffuse(wi.z, wo.z, o.x, i.x, alpha));
    put(grazing_albedo(wo.z));
    put(vec2(bounces.grazing, bounces.again));
    put(vec2(bounces.lean, bounces.lost));
    put(vec2(lossy.grazing, lossy.again));
    put(vec2(lossy.lean, lossy.lost));
}
