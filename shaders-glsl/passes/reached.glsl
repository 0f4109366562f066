// What the multisampled geometry knows of a triangle in a pixel, beside the surface: where in the pixel it was looked at, since it need
// not reach the middle. See geometry.frag and msaa.comp.
#ifndef LEADR_REACHED
#define LEADR_REACHED
#include "constants.glsl"
#include "geometry/place.glsl"
#include "leadr/frame.glsl"

// Where in an image of such a size (pixels) a point in clip space lies, in pixels times its w, and w. The viewport is GUARD_BAND times
// the image.
vec3 window_place(const vec4 clip, const vec2 size) {
    return vec3(0.5 * (GUARD_BAND * clip.xy + clip.w) * size, clip.w);
}

#ifdef LEADR_FRAGMENT
// What an input that a driver interpolates elsewhere than in the middle of a pixel has to be divided by. It is 1 but for drivers
// (lavapipe) that undo the perspective there as in the middle. w: of clip space, interpolated in the same way.
float perspective_at(const vec2 from_middle, const float w) {
    float there = gl_FragCoord.w + dFdx(gl_FragCoord.w) * from_middle.x + dFdy(gl_FragCoord.w) * from_middle.y;
    return w * there;
}
#endif

// A location in a pixel, from its middle, as 8 bits: sixteenths of the pixel.
uint pack_location(const vec2 from_middle) {
    uvec2 sixteenths = uvec2(clamp(round(from_middle * 16.0) + 8.0, 0.0, 15.0));
    return sixteenths.x | sixteenths.y << 4;
}

vec2 location_of(const uint packed) {
    return (vec2(packed & 0xfu, packed >> 4 & 0xfu) - 8.0) / 16.0;
}

// from_middle: of the pixel; normal: displacement direction, with 12 bits each way; away: how far the place is from that in the
// middle of the pixel.
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
