#version 460
#include "leadr/shadowed_environment.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    vec2 slope = next2();
    vec2 across = next2();
    at = gl_GlobalInvocationID.x * 12;
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = direction_area(wo, m, cholesky);
    put(visible_slope_shift(o, cholesky));
    BentNormal v = bent_normal(o, m, cholesky);
    put(v.normal);
    put(v.open);
    vec3 c[9];
    for (int i = 0; i < 9; ++i) c[i] = vec3(0.0);
    c[0] = vec3(2.0, 1.5, 1.0);
    sh_add_light(c, vec3(0.6, 0.0, 0.8), vec3(1.0, 2.0, 3.0));
    put(shadowed_diffuse_environment(v, frame_about(wo), c));
    for (int visibility = LEADR_VISIBILITY_SMITH; visibility <= LEADR_VISIBILITY_CORRELATED_SIMPLE; ++visibility)
        put(lit_probe(visibility, o, wo, slope, across, m, cholesky));
}
