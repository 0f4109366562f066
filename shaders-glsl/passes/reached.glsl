// Additional data for a triangle in a multisampled pixel: the point within the pixel at which the surface is evaluated, since the triangle
// need not cover the pixel's centre. geometry.frag writes the data, and msaa.comp reads them.
#ifndef LEADR_REACHED
#define LEADR_REACHED
#include "constants.glsl"
#include "geometry/footprint.glsl"
#include "leadr/frame.glsl"

// Returns the image position of a point in clip space, in pixels times w, and w. size is the size of the image in pixels. The viewport is
// GUARD_BAND times the image.
vec3 window_position(const vec4 clip, const vec2 size) {
    return vec3(0.5 * (GUARD_BAND * clip.xy + clip.w) * size, clip.w);
}

#ifdef LEADR_FRAGMENT
// Returns the divisor of an input that a driver interpolates away from the pixel centre. The divisor is 1 on most drivers. Some drivers
// (lavapipe) undo the perspective with the value at the pixel centre. w is the w of clip space, interpolated in the same way.
float perspective_at(const vec2 from_middle, const float w) {
    float there = gl_FragCoord.w + dFdx(gl_FragCoord.w) * from_middle.x + dFdy(gl_FragCoord.w) * from_middle.y;
    return w * there;
}
#endif

// Packs a location relative to the pixel centre in 8 bits, in sixteenths of a pixel.
uint pack_location(const vec2 from_middle) {
    uvec2 sixteenths = uvec2(clamp(round(from_middle * 16.0) + 8.0, 0.0, 15.0));
    return sixteenths.x | sixteenths.y << 4;
}

vec2 location_of(const uint packed) {
    return (vec2(packed & 0xfu, packed >> 4 & 0xfu) - 8.0) / 16.0;
}

// Packs a triangle's data. from_middle is the position relative to the pixel centre, and normal is the displacement direction, with 12 bits
// per coordinate. away is the offset of the point from the point at the pixel centre.
uvec2 pack_reached(const vec2 from_middle, const vec3 normal, const vec2 away) {
    uvec2 direction = uvec2(ivec2(round(octahedral_encode(normal) * 2047.0))) & 0xfffu;
    return uvec2(pack_location(from_middle) | direction.x << 8 | direction.y << 20,
                 packHalf2x16(clamp(away * FOOTPRINT_SCALE, -6e4, 6e4)));
}

vec3 direction_of(const uvec2 packed) {
    ivec2 direction = ivec2(packed.x << 12, packed.x) >> 20;
    return octahedral_decode(vec2(direction) / 2047.0);
}

// Whether two directions are certainly less than 20 degrees apart.
bool same_direction(const uvec2 a, const uvec2 b) {
    ivec2 apart = abs((ivec2(a.x << 12, a.x) >> 20) - (ivec2(b.x << 12, b.x) >> 20));
    return max(apart.x, apart.y) < 350;
}

vec2 away_of(const uvec2 packed) {
    return unpackHalf2x16(packed.y) / FOOTPRINT_SCALE;
}

#endif
