#version 460
#extension GL_GOOGLE_include_directive : require
// The visible patch and the position on it. Small triangles run this stage several times per pixel, so the work is left to the
// filter pass, which runs once per pixel.
#include "seen.glsl"

void main() {
    write_seen();
}
