#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/geometric_antialiasing.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 17;
    vec3 wh = next3();
    vec3 dx = next3();
    vec3 dy = next3();
    vec2 m = next2();
    vec3 S = next3();
    vec3 kernel = next3();
    at = gl_GlobalInvocationID.x * 22;
    put(half_vector_kernel(wh, dx, dy));
    put(tilt_kernel(kernel, m));
    put(kernel_over(kernel, S));
    put(axis_aligned_kernel(kernel).xy);
    put(isotropic_kernel(kernel).xy);
    put(filter_covariance(S, kernel));
    put(filter_roughness(S, kernel));
    put(clamp_determinant(S, 1e-2).z);
    put(ggx_ndf_clamped(wh, m, S, 1e-4));
    put(ggx_ndf_clamped(wh, m, filter_roughness(S, kernel), 1e-4));
}
