#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/phong.glsl"
#include "leadr/slopes/grid.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 10;
    vec3 wh = next3();
    vec2 m = next2();
    vec3 C = clamp_covariance(next3());
    vec2 p = next2();
    at = gl_GlobalInvocationID.x * 11;
    float n = phong_exponent(C);
    put(log2(n));
    // In units of the largest density, at a slope near the mean and at a normal.
    float most = (n + 2.0) * (0.5 / LEADR_PI);
    put(phong_p22(slope_at(p, m, slope_cholesky(C)), m, C) / most);
    put(phong_ndf(wh, m, C) * pow(max(wh.z, LEADR_MIN_NORMAL_Z), 4.0) / most);
    vec3 unit = C / max(C.x + C.y, 1e-8);
    put(phong_masking(C) / max(C.x + C.y, 1e-8));
    GaussianLobe wide = phong_lobe(C, 0), narrow = phong_lobe(C, 1);
    put(wide.weight);
    put(narrow.weight);
    put(wide.S.x / max(C.x, 1e-8));
    put(narrow.S.y / max(C.y, 1e-8));
    put(unit.z);
}
