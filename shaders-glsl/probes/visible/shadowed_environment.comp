#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/shadowed_environment.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = clamp_covariance(next3());
    at = gl_GlobalInvocationID.x * 9;
    put(visible_tilt(wo, m, S).shift);
    BentNormal v = bent_normal(wo, m, S);
    put(v.normal);
    put(v.open);
    vec3 c[9];
    for (int i = 0; i < 9; ++i) c[i] = vec3(0.0);
    c[0] = vec3(2.0, 1.5, 1.0);
    sh_add_light(c, vec3(0.6, 0.0, 0.8), vec3(1.0, 2.0, 3.0));
    put(shadowed_diffuse_environment(v, frame_about(wo), c, vec3(0.1, -0.2, 0.3)));
}
