#version 460
#extension GL_GOOGLE_include_directive : require
// Shades pixels that show only sky.
#include "lighting.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(sky_radiance(pixel_ray(gl_FragCoord.xy)), 0.0);
}
