#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel sees, before any filtering. Small triangles run this stage several times per pixel, so it reads no texture:
// the filter pass does that, once per pixel.
#include "object.glsl"
#include "view.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"
#include "leadr/slopes/statistics.glsl"

uniform sampler2D height_map;

layout(location = 0) in vec3 in_normal;
layout(location = 1) in vec3 in_tangent_s;
layout(location = 2) in vec3 in_tangent_t;
layout(location = 3) in vec2 in_texcoord;
layout(location = 4) in vec4 in_color;
layout(location = 5) in float in_accessibility;
layout(location = 6) in flat uint in_patch;

layout(location = 0) out uvec4 out_texture; // texture coordinate, its derivatives by x and y in texels of the maps
layout(location = 1) out uvec4 out_tangent; // displacement direction, tangents by texture coordinate
layout(location = 2) out uvec4 out_surface; // object and patch, macro curvature, accessibility, colour

void main() {
    vec3 normal = normalize(in_normal);
    Frame frame = frame_about(normal);
    // How far the macro normal turns across one pixel, as a difference of slopes.
    float across = view.camera_position.w;
    vec3 curvature = add_macro_curvature(vec3(0.0), -across * to_frame(frame, dFdx(normal)).xy,
                                         -across * to_frame(frame, dFdy(normal)).xy);
    vec2 size = vec2(textureSize(height_map, 0));
    vec2 dx = clamp(dFdx(in_texcoord) * across * size, -6e4, 6e4), dy = clamp(dFdy(in_texcoord) * across * size, -6e4, 6e4);
    out_texture = uvec4(floatBitsToUint(in_texcoord), packHalf2x16(dx), packHalf2x16(dy));
    vec3 ts = clamp(in_tangent_s, -6e4, 6e4), tt = clamp(in_tangent_t, -6e4, 6e4);
    out_tangent = uvec4(packSnorm2x16(octahedral_encode(normal)), packHalf2x16(ts.xy),
                        packHalf2x16(vec2(ts.z, tt.x)), packHalf2x16(tt.yz));
    // A triangle seen exactly edge-on can be rasterised with a meaningless depth: nothing lies at or before the near plane.
    bool broken = !(gl_FragCoord.z < 1.0);
    bool inside = (object.flags & FLAG_MARK_INSIDE) != 0u && !gl_FrontFacing;
    uint seen = object.index << 24 | (in_patch & PATCH_BITS) | (inside ? INSIDE : 0u);
    out_surface = uvec4(broken ? 0u : seen, packHalf2x16(curvature.xy),
                        packHalf2x16(vec2(curvature.z, in_accessibility)), packUnorm4x8(in_color));
}
