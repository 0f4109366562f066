#version 460
#extension GL_GOOGLE_include_directive : require
// The sky at pixels that show no object: others fail the depth test.
#include "lighting.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(sky_radiance(pixel_ray(gl_FragCoord.xy)), 0.0);
}
