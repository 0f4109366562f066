#version 460
#include "leadr/visible/relief_color.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3(), wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float lit = next();
    at = gl_GlobalInvocationID.x * 10;
    vec3 cholesky = slope_cholesky(clamp_covariance(S));
    float height = seen_height(direction_area(wo, m, cholesky), lit);
    vec2 score = lit_slopes_score(wo, wi, m, S);
    put(height);
    put(score);
    put(seen_slopes_score(wo, m, S));
    ReliefColor r = ReliefColor(vec3(0.1, -0.02, 0.0), vec3(0.2, -0.03, 0.01), vec3(0.03, 0.0, -0.01), vec3(0.0, 0.02, 0.01));
    put(relief_color(vec3(0.5, 0.2, 0.9), r, height, clamp(score, -3.0, 3.0)));
    put(held_score(score, S));
}
