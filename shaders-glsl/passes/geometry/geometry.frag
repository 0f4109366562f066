#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the visible patch and the position on it. For small triangles, this stage runs several times per pixel. The filter pass runs once
// per pixel, so it does the remaining work.
#include "seen.glsl"

void main() {
    write_seen();
}
