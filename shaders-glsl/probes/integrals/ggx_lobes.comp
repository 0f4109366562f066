#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/ggx_lobes.glsl"
#include "leadr/slopes/grid.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 S = next3();
    float alpha = next();
    at = gl_GlobalInvocationID.x * 24;
    DisplacedGgx d = displaced_ggx(vec3(vec2(alpha * alpha), 0.0), S);
    vec3 cholesky = slope_cholesky(0.5 * d.roughness);
    DirectionArea o = displaced_ggx_area(wo, m, d, cholesky);
    put(o.spread);
    put(o.visible);
    for (int k = 0; k < LEADR_GGX_LOBES; ++k) {
        GaussianLobe lobe = ggx_lobe(d, k);
        put(lobe.weight);
        put(lobe.S);
    }
    for (int shadowing = LEADR_SHADOWING_NONE; shadowing <= LEADR_SHADOWING_CORRELATED; ++shadowing) {
        put(displaced_ggx_light(shadowing, o, wo, wi, m, d, cholesky, vec3(0.04, 0.5, 1.0)).xy);
    }
}
