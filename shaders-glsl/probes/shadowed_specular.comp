#version 460
#include "leadr/shadowed_specular.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 27;
    VisibleSlopes v = visible_slopes(wo, m, S);
    for (int visibility = LEADR_VISIBILITY_SMITH; visibility <= LEADR_VISIBILITY_CORRELATED_SIMPLE; ++visibility) {
        LitSlopes lit = lit_slopes(visibility, wo, v, line_rule(5));
        put(lit.lit);
        put(lit.slopes.mean);
        put(lit.slopes.cov);
        put(lit.slopes.facet);
        put(lit.slopes.variance);
        put(lit.slopes.third);
    }
}
