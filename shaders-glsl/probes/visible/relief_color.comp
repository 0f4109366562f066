#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/relief_color.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3(), wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float lit = next();
    at = gl_GlobalInvocationID.x * 17;
    vec3 cholesky = slope_cholesky(clamp_covariance(S));
    float height = seen_height(direction_area(wo, m, cholesky), lit);
    SlopesScore score = lit_slopes_score(wo, wi, m, S), seen = seen_slopes_score(wo, m, S);
    put(height);
    put(score.moved);
    put(score.narrowed);
    put(seen.moved);
    put(seen.narrowed);
    ReliefColor r = ReliefColor(vec3(0.1, -0.02, 0.0), vec3(0.2, -0.03, 0.01), vec3(0.03, 0.0, -0.01), vec3(0.0, 0.02, 0.01));
    vec3 change = slopes_change(r, score, S);
    put(change);
    put(relief_color(vec3(0.5, 0.2, 0.9), r, height, change));
}
