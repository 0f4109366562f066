// Data of multisampled geometry for a triangle in a pixel, beyond the surface: the evaluation point within the pixel, since the
// triangle need not cover the centre. See geometry.frag and msaa.comp.
#ifndef LEADR_REACHED
#define LEADR_REACHED
#include "constants.glsl"
#include "geometry/footprint.glsl"
#include "leadr/frame.glsl"

// Image position of a point in clip space, in pixels times its w, and w. size: of the image, pixels. The viewport is GUARD_BAND
// times the image.
vec3 window_position(const vec4 clip, const vec2 size) {
    return vec3(0.5 * (GUARD_BAND * clip.xy + clip.w) * size, clip.w);
}

#ifdef LEADR_FRAGMENT
// Divisor of an input that a driver interpolates away from the pixel centre. It is 1 except on drivers (lavapipe) that undo the
// perspective there as at the centre. w: of clip space, interpolated in the same way.
float perspective_at(const vec2 from_middle, const float w) {
    float there = gl_FragCoord.w + dFdx(gl_FragCoord.w) * from_middle.x + dFdy(gl_FragCoord.w) * from_middle.y;
    return w * there;
}
#endif

// A location relative to the pixel centre, in 8 bits: sixteenths of the pixel.
uint pack_location(const vec2 from_middle) {
    uvec2 sixteenths = uvec2(clamp(round(from_middle * 16.0) + 8.0, 0.0, 15.0));
    return sixteenths.x | sixteenths.y << 4;
}

vec2 location_of(const uint packed) {
    return (vec2(packed & 0xfu, packed >> 4 & 0xfu) - 8.0) / 16.0;
}

// from_middle: position relative to the pixel centre; normal: displacement direction, 12 bits per coordinate; away: offset of
// the point from that at the pixel centre.
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
