#version 460
#extension GL_GOOGLE_include_directive : require
// Displaces the sea by the waves of every cascade, filtered to the vertex spacing. Positions on an edge are computed from its lower vertex,
// so that both patches at an edge compute the same bits.
#include "surface.glsl"
#include "../reached.glsl"

layout(quads, fractional_odd_spacing, cw) in;

layout(location = 0) in vec3 in_rest[];
layout(location = 1) patch in uint in_patch;

layout(location = 0) out vec2 out_rest; // relative to the centre
layout(location = 1) out vec2 out_rest_reached; // same value as out_rest
layout(location = 2) out vec3 out_window; // window_position
layout(location = 3) out flat vec4 out_patch_bounds; // least and greatest rest position of the patch, relative to the centre

vec3 between(const vec3 a, const vec3 b, const float t) {
    precise vec3 p = a * (1.0 - t) + b * t;
    return p;
}

void main() {
    float u = gl_TessCoord.x, v = gl_TessCoord.y;
    vec3 rest;
    if (u == 0.0 || u == 1.0 || v == 0.0 || v == 1.0) {
        int side = v == 0.0 ? 0 : (u == 1.0 ? 1 : (v == 1.0 ? 2 : 3));
        float t = side == 0 ? u : (side == 1 ? v : (side == 2 ? 1.0 - u : 1.0 - v));
        vec3 a = in_rest[side], b = in_rest[(side + 1) & 3];
        bool backwards = (patch_edges[in_patch][side] & 1u) != 0u;
        rest = backwards ? between(b, a, 1.0 - t) : between(a, b, t);
    } else {
        rest = between(between(in_rest[0], in_rest[1], u), between(in_rest[3], in_rest[2], u), v);
    }
    out_rest = rest.xy - view.centre.xy;
    vec2 a = in_rest[0].xy, b = in_rest[1].xy, c = in_rest[2].xy, d = in_rest[3].xy;
    out_patch_bounds = vec4(min(min(a, b), min(c, d)), max(max(a, b), max(c, d))) - view.centre.xyxy;
    gl_Position = view.clip_from_world * vec4(carried(rest), 1.0);
    out_rest_reached = out_rest;
    out_window = window_position(gl_Position, view.window.xy);
}
