#version 460
#extension GL_GOOGLE_include_directive : require
// Draws undivided patches as two triangles each, without the cost of the tessellation stages.
#include "interface.glsl"
#include "corner.glsl"
#include "../reached.glsl"
#include "../tiling.glsl"

layout(constant_id = 4) const bool BY_EXAMPLE = false; // as in geometry.tese

layout(location = 0) out vec2 out_patch_uv; // as in geometry.tese
layout(location = 1) out vec3 out_normal;
layout(location = 2) out flat uint out_patch;
layout(location = 3) out vec2 out_patch_uv_reached;
layout(location = 4) out vec3 out_window;

invariant gl_Position;

void main() {
    const uint order[6] = uint[6](0, 1, 3, 1, 2, 3);
    uint patch_index = visible_patches[gl_VertexIndex / 6], corner = order[gl_VertexIndex % 6];
    PatchData data = patches[patch_index];
    uint index = data.vertices[corner];
    Vertex vertex = vertices[index];
    precise vec3 normal = displacement_normal(vertex.normal.xyz);
    vec2 patch_uv = vec2(corner == 1u || corner == 2u ? 1.0 : 0.0, corner >= 2u ? 1.0 : 0.0);
    float height = (OBJECT.flags & FLAG_DISPLACED) != 0u ? vertex_height(index) : 0.0;
    if (BY_EXAMPLE) {
        vec2 at = patch_texcoord(data, patch_uv.x, patch_uv.y).at;
        height = whole_height(tiled_height(height_map, OBJECT.flags, at + OBJECT.shift, height), at, height, vertex.facing.w);
    }
    precise float scaled = height * OBJECT.displacement;
    precise vec3 displaced_position = vertex.position.xyz + normal * scaled;

    out_patch_uv = (OBJECT.flags & FLAG_FLAT) != 0u ? patch_texcoord(data, patch_uv.x, patch_uv.y).at : patch_uv;
    out_normal = (OBJECT.flags & FLAG_TRIANGLES) != 0u ? vertex.facing.xyz : normal;
    out_patch = patch_index;
    gl_Position = VIEW.clip_from_world * vec4(displaced_position, 1.0);
    out_patch_uv_reached = out_patch_uv;
    out_window = window_position(gl_Position, VIEW.size);
}
