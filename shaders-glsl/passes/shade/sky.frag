#version 460
#extension GL_GOOGLE_include_directive : require
// The sky behind pixels that show no object.
#include "lighting.glsl"
#include "../visible.glsl"

uniform usampler2D visible_surface;

layout(location = 0) out vec4 out_radiance;

void main() {
    if (object_of(texelFetch(visible_surface, ivec2(gl_FragCoord.xy), 0).x) != 0u) {
        discard;
    }
    out_radiance = vec4(sky_radiance(pixel_ray(gl_FragCoord.xy)), 0.0);
}
