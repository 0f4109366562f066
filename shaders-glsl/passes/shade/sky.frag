#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Draws the sky at pixels that show no object. Other pixels fail the depth test.
#include "lighting.glsl"
#include "../visible.glsl"

layout(constant_id = 60) const bool MULTISAMPLED = false; // whether lists of pixels are drawn, which includes the sky

uniform usampler2D visible_surface;

layout(location = 0) out vec4 out_radiance;

void main() {
    vec2 at = MULTISAMPLED ? position_of(texelFetch(visible_surface, ivec2(gl_FragCoord.xy), 0).w) : gl_FragCoord.xy;
    out_radiance = vec4(sky_radiance(pixel_ray(at)), 0.0);
}
