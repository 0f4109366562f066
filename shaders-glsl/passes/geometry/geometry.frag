#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel sees: the patch, and where on it. Small triangles run this stage several times per pixel, so it reads nothing and
// works nothing out: the filter pass does that, once per pixel.
#include "seen.glsl"

void main() {
    write_seen();
}
