#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/diffuse.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    int n = int(next());
    at = gl_GlobalInvocationID.x * 20;
    float lambda = grid_lambda(n);
    m = face_viewer(wo, m, S, lambda);
    NormalMoments v = visible_normal_moments(wo, m, S, n, lambda);
    put(v.mean);
    put(v.diag);
    put(v.off);
    vec3 c[9];
    for (int i = 0; i < 9; ++i) c[i] = vec3(0.0);
    c[0] = vec3(2.0, 1.5, 1.0);
    sh_add_light(c, vec3(0.6, 0.0, 0.8), vec3(1.0, 2.0, 3.0));
    sh_add_light(c, vec3(0.0, -0.8, -0.6), vec3(0.3, 0.2, 0.1));
    put(leadr_diffuse_environment(v, frame_about(wi), c, vec3(0.1, -0.2, 0.3)));
    put(leadr_diffuse_light_sh(v, wo, wi, m, S, true));
    put(leadr_diffuse_light_sh(v, wo, wi, m, S, false));
    put(leadr_diffuse_light(wo, wi, m, S, true, n, lambda));
    put(leadr_diffuse_light(wo, wi, m, S, false, n, lambda));
    // Seen edge-on, the visible parts of grooves have relative rounding errors.
    float edge = clamp(meso_area(wo, m), 0.0, 1.0);
    put(edge * groove_normal_moments(wo, m, S, n, lambda).mean);
    put(edge * groove_diffuse_light(wo, wi, m, S, n, lambda));
}
