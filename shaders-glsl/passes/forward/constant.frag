#version 460
// The cheapest possible fragment shader.
#extension GL_GOOGLE_include_directive : require
#include "forward.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(forward.material.rgb, 1.0);
}
