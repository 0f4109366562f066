#ifndef LEADR_FORWARD_POINT
#define LEADR_FORWARD_POINT
// The shaded point, with its tangent frame and the slopes from its maps.
#include "forward.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec3 in_tangent;
layout(location = 3) in vec3 in_bitangent;
layout(location = 4) in vec2 in_texcoord;

layout(location = 0) out vec4 out_radiance;

uniform sampler2D slope_map; // E[hs], E[ht], E[hs^2], E[ht^2]

struct Point {
    Frame frame;
    vec3 wo;    // direction toward the viewer, in the frame
    vec2 scale; // slopes per unit of the height's derivative by texture coordinates
};

Point shaded_point() {
    vec2 per_metre = inversesqrt(vec2(dot(in_tangent, in_tangent), dot(in_bitangent, in_bitangent)));
    Frame frame = Frame(in_tangent * per_metre.x, in_bitangent * per_metre.y, normalize(in_normal));
    vec3 wo = to_frame(frame, normalize(forward.camera_position.xyz - in_position));
    return Point(frame, wo, forward.surface.y * per_metre);
}

// Returns the direction to the sun in the frame.
vec3 sun_in(const Frame frame) {
    return to_frame(frame, forward.sun_direction.xyz);
}

#endif
