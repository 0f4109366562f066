#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/sh.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 d = next3();
    vec3 c[9];
    for (int i = 0; i < 9; ++i) c[i] = next() * vec3(1.0, 2.0, -0.5);
    at = gl_GlobalInvocationID.x * 18;
    float basis[9] = sh_basis(d);
    for (int i = 0; i < 9; ++i) put(basis[i]);
    put(sh_irradiance(c, d));
    sh_add_light(c, vec3(0.6, 0.0, 0.8), vec3(1.0, 2.0, 3.0));
    put(sh_irradiance(c, d));
    put(sh_irradiance_light(d.x));
    put(sh_irradiance_rest(d.x));
    put(sh_rest_damping(0.9 * d));
}
