#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 13;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    vec2 p = next2();
    at = gl_GlobalInvocationID.x * 17;
    const vec3 f0 = vec3(0.04, 0.5, 1.0);
    put(leadr_specular_directional(wo, wi, m, S, f0, true));
    put(leadr_specular_directional(wo, wi, m, S, f0, false));
    vec3 cholesky = slope_cholesky(S);
    put(leadr_specular_light(LEADR_SHADOWING_CORRELATED, direction_area(wo, m, cholesky), direction_area(wi, m, cholesky), wo, wi, m, S, f0));
    EnvironmentSample e = environment_sample(wo, p, m, S);
    put(e.wi);
    put(e.wn);
    put(e.area);
    put(env_lod(wo, e.wn, S, 0.9, 256.0, LEADR_LOD_MATCHED));
}
