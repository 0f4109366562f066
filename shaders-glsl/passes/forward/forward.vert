#version 460
#extension GL_GOOGLE_include_directive : require
// Outputs the corners of a quad with their tangents, in the same format as a mesh.
#include "forward.glsl"

struct Corner {
    vec4 position;  // xyz; w: u
    vec4 normal;    // xyz; w: v
    vec4 tangent;   // metres per unit of u
    vec4 bitangent; // metres per unit of v
};
layout(std430) readonly buffer Corners { Corner corners[]; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec3 out_tangent;
layout(location = 3) out vec3 out_bitangent;
layout(location = 4) out vec2 out_texcoord;

void main() {
    const int order[6] = int[6](0, 1, 2, 0, 2, 3);
    Corner corner = corners[order[gl_VertexIndex]];
    out_position = corner.position.xyz;
    out_normal = corner.normal.xyz;
    out_tangent = corner.tangent.xyz;
    out_bitangent = corner.bitangent.xyz;
    out_texcoord = vec2(corner.position.w, corner.normal.w);
    gl_Position = forward.clip_from_world * vec4(out_position, 1.0);
}
