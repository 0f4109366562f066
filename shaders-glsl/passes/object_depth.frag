#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the object at each pixel, encoded as a depth.
#include "object_depth.glsl"
#include "visible.glsl"

uniform usampler2D visible_surface;

layout(depth_any) out float gl_FragDepth;

void main() {
    uint word = texelFetch(visible_surface, ivec2(gl_FragCoord.xy), 0).x;
    gl_FragDepth = word == NOBODY ? NOBODY_DEPTH : object_depth(object_of(word));
}
