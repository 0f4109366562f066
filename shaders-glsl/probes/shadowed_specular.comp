#version 460
#include "leadr/shadowed_specular.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 10;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    vec2 major = next2();
    at = gl_GlobalInvocationID.x * 13;
    VisibleSlopes v = visible_slopes(wo, m, S);
    vec3 cholesky = slope_cholesky(v.S);
    DirectionArea o = direction_area(wo, v.m, cholesky);
    for (int visibility = LEADR_VISIBILITY_SMITH; visibility <= LEADR_VISIBILITY_CORRELATED_SIMPLE; ++visibility) {
        LitLine lit = lit_line(visibility, o, wo, v, major, cholesky, line_rule(5));
        put(lit.mean);
        put(lit.slope);
        put(lit.curve);
        put(lit_along(lit, 1.5));
    }
    LitLine half_lit = LitLine(0.5 * wo.z * wo.z, 0.0, 0.0);
    put(lit_scale(half_lit, 1.0));
}
