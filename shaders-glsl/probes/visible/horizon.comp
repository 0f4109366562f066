#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/horizon.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 11;
    vec3 wi = next3();
    vec2 m = next2();
    Horizon h;
    h.lean = next2();
    h.spread = next3();
    float deviation = next();
    at = gl_GlobalInvocationID.x * 9;
    put(horizon_excess(wi.xy, h));
    put(horizon_visibility(wi, m, h, deviation));
    Hidden hidden = horizon_hidden(m, h);
    put(hidden.weight);
    put(hidden.angle);
    vec3 c[9];
    for (int i = 0; i < 9; ++i) {
        c[i] = vec3(0.0);
    }
    c[0] = vec3(2.0, 1.5, 1.0);
    sh_add_light(c, vec3(0.6, 0.0, 0.8), vec3(1.0, 2.0, 3.0));
    put(diffuse_past_horizon(vec3(2.0, 0.5, 0.1), 0.8, hidden, m, frame_about(wi), c));
}
