#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/frame.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    vec3 z = next3();
    vec3 d = next3();
    at = gl_GlobalInvocationID.x * 14;
    Frame f = frame_about(z);
    put(f.x);
    put(f.y);
    put(to_frame(f, d));
    put(octahedral_encode(d));
    put(octahedral_decode(d.xy));
}
