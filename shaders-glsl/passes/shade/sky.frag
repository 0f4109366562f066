#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// The sky at pixels that show no object: others fail the depth test.
#include "lighting.glsl"
#include "../visible.glsl"

layout(constant_id = 60) const bool MULTISAMPLED = false; // lists of pixels are drawn, also for the sky

uniform usampler2D visible_surface;

layout(location = 0) out vec4 out_radiance;

void main() {
    vec2 at = MULTISAMPLED ? position_of(texelFetch(visible_surface, ivec2(gl_FragCoord.xy), 0).w) : gl_FragCoord.xy;
    out_radiance = vec4(sky_radiance(pixel_ray(at)), 0.0);
}
