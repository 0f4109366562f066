#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/map.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 14;
    vec3 ts = next3();
    vec3 tt = next3();
    vec3 z = next3();
    vec2 gradient = next2();
    vec3 S = next3();
    at = gl_GlobalInvocationID.x * 11;
    vec3 x = normalize(cross(abs(z.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0), z));
    SlopeMap map = slope_map(ts, tt, x, cross(z, x), z);
    put(map.linear_s);
    put(map.linear_t);
    put(map.offset);
    put(map_mean_slope(map, gradient));
    put(map_covariance(map, S));
}
