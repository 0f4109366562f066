#version 460
#extension GL_GOOGLE_include_directive : require
// Sets the subdivision of a patch, and culls patches that the waves move out of view.
#include "../constants.glsl"
#include "surface.glsl"

layout(vertices = 4) out;

layout(location = 0) in vec3 in_rest[];
layout(location = 1) in flat uint in_patch[];

layout(location = 0) out vec3 out_rest[];
layout(location = 1) patch out uint out_patch;


// Whether a sphere lies outside the view or in front of the near plane.
bool outside(const vec3 centre, const float radius) {
    mat4 rows = transpose(view.clip_from_world);
    vec4 x = GUARD_BAND * rows[0], y = GUARD_BAND * rows[1], w = rows[3];
    vec4 planes[5] = vec4[](w + x, w - x, w + y, w - y, w - rows[2]);
    for (int i = 0; i < 5; ++i) {
        if (dot(planes[i], vec4(centre, 1.0)) < -radius * length(planes[i].xyz)) {
            return true;
        }
    }
    return false;
}

// Tests a bounding sphere of the displaced corners. Between the corners, waves with slopes of up to 1 add at most half the diagonal.
bool unseen() {
    vec3 corners[4], centre = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        corners[i] = carried(in_rest[i]);
        centre += 0.25 * corners[i];
    }
    float radius = 0.0;
    for (int i = 0; i < 4; ++i) {
        radius = max(radius, distance(corners[i], centre));
    }
    vec2 a = in_rest[2].xy - in_rest[0].xy, b = in_rest[3].xy - in_rest[1].xy;
    return outside(centre, radius + 0.5 * sqrt(max(dot(a, a), dot(b, b))));
}

void main() {
    out_rest[gl_InvocationID] = in_rest[gl_InvocationID];
    if (gl_InvocationID == 0) {
        out_patch = in_patch[0];
        uvec4 edge = patch_edges[in_patch[0]] >> 1;
        vec4 factor = vec4(edge_factors[edge.x], edge_factors[edge.y], edge_factors[edge.z], edge_factors[edge.w]);
        gl_TessLevelOuter[0] = factor.w;
        gl_TessLevelOuter[1] = factor.x;
        gl_TessLevelOuter[2] = factor.y;
        gl_TessLevelOuter[3] = factor.z;
        gl_TessLevelInner[0] = max(factor.x, factor.z);
        gl_TessLevelInner[1] = max(factor.y, factor.w);
        if (unseen()) {
            gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = gl_TessLevelOuter[3] = 0.0;
        }
    }
}
