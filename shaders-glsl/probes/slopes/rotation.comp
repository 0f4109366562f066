#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/frame.glsl"
#include "leadr/slopes/rotation.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 17;
    Frame from = frame_about(next3()), to = frame_about(next3());
    vec2 mean = next2();
    vec3 S = next3();
    SlopePart other;
    other.mean = next2();
    other.covariance = next3();
    other.area = next();
    at = gl_GlobalInvocationID.x * 12;
    mat3 rotation = mat3(to_frame(to, from.x), to_frame(to, from.y), to_frame(to, from.z));
    SlopePart part = rotate_slopes(rotation, mean, S);
    SlopePart whole = join_slopes(other, part);
    put(part.mean);
    put(part.covariance);
    put(part.area);
    put(whole.mean);
    put(whole.covariance);
    put(whole.area);
}
