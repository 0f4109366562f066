#version 460
#extension GL_GOOGLE_include_directive : require

// Converts linear radiance to display codes. One image is shown to the left of a line, and another to the right of the line.

#include "tonemap.glsl"

layout(constant_id = 0) const int TONEMAP = 1;          // operator (see tonemap.glsl)
layout(constant_id = 1) const bool ENCODE_SRGB = true;  // false if the target format encodes sRGB

uniform sampler2D image;
uniform sampler2D other;

layout(push_constant) uniform Constants {
    float exposure; // factor
    float split;    // fraction of the width that shows image
    float dithering; // 1 to dither, 0 to round to the nearest code
};

layout(location = 0) in vec2 in_texcoord;
layout(location = 0) out vec4 out_color;

vec3 srgb_from_linear(const vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

vec3 linear_from_srgb(const vec3 x) {
    return mix(x / 12.92, pow((x + 0.055) / 1.055, vec3(2.4)), greaterThan(x, vec3(0.04045)));
}

void main() {
    vec3 radiance = in_texcoord.x < split ? textureLod(image, in_texcoord, 0.0).rgb : textureLod(other, in_texcoord, 0.0).rgb;
    vec3 exposed = radiance * exposure;
    vec3 display = srgb_from_linear(display_light(TONEMAP, exposed));
    display = clamp(display + dithering / 255.0 * dither(uvec2(gl_FragCoord.xy)), 0.0, 1.0);
    if (!ENCODE_SRGB) {
        display = linear_from_srgb(display);
    }
    // Invalid texels must be visible, not black. The bits of the texels are tested, because compilers may assume that NaN does not occur.
    uvec3 magnitude = floatBitsToUint(radiance) & 0x7fffffffu;
    if (any(greaterThan(magnitude, uvec3(0x7f800000u)))) {
        display = vec3(1.0, 0.0, 1.0);
    }
    out_color = vec4(display, 1.0);
}
