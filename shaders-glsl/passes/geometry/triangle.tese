#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"
#include "corner.glsl"
#include "edge.glsl"
#include "rest_triangle.glsl"
#include "triangle.glsl"
#include "../reached.glsl"

layout(triangles, fractional_odd_spacing, ccw) in;

layout(location = 0) in vec3 in_position[];
layout(location = 1) in vec3 in_normal[];
layout(location = 2) patch in uint in_patch;

layout(location = 0) out vec2 out_patch_uv; // as in geometry.tese
layout(location = 1) out vec3 out_normal;
layout(location = 2) out flat uint out_patch;
layout(location = 3) out vec2 out_patch_uv_reached;
layout(location = 4) out vec3 out_window;

invariant gl_Position;

// Returns the unclamped level of the heights inside a triangle whose longest side spans this many texels.
float height_spacing(const float texels) {
    return log2(max(texels / gl_TessLevelInner[0], 1e-20)) - FINER;
}

void main() {
    vec3 share = gl_TessCoord; // barycentric weight of each corner
    PatchData data = patches[in_patch];
    uint corner[3] = uint[3](data.vertices.x, data.vertices.y, data.vertices.w);
    vec3 facing[3] = vec3[3](vertices[corner[0]].facing.xyz, vertices[corner[1]].facing.xyz, vertices[corner[2]].facing.xyz);
    bool displaced = (OBJECT.flags & FLAG_DISPLACED) != 0u;
    float height = 0.0;
    vec3 position, normal;
    // On the boundary, everything is computed from the edge's own data, in the edge's own direction (from its lower position). All adjacent
    // triangles therefore compute the same bits, even if their texture coordinates and normals differ.
    if (share.x == 0.0 || share.y == 0.0 || share.z == 0.0) {
        int from = share.z == 0.0 ? 0 : (share.x == 0.0 ? 1 : 2), to = from == 2 ? 0 : from + 1;
        float t = share[to];
        uint side = from == 0 ? data.edges.x : (from == 1 ? data.edges.y : data.edges.w);
        if ((side & 1u) != 0u) {
            t = share[from];
            int swap = from;
            from = to;
            to = swap;
        }
        precise vec3 between = in_position[from] * (1.0 - t) + in_position[to] * t;
        precise vec3 along = in_normal[from] * (1.0 - t) + in_normal[to] * t;
        position = between;
        normal = displacement_normal(along);
        if (displaced) {
            height = t == 0.0 ? vertex_height(corner[from]) : (t == 1.0 ? vertex_height(corner[to]) : edge_height(side >> 1, t));
        }
    } else {
        position = in_position[0] * share.x + in_position[1] * share.y + in_position[2] * share.z;
        normal = triangle_normal(vec3[3](in_normal[0], in_normal[1], in_normal[2]), facing, share.yz).normal;
        // The height is filtered to about the vertex spacing. Shading accounts for bumps that are too fine for the geometry.
        vec2 size = vec2(textureSize(height_map, 0));
        float scale_of_vertices = SCALED_BY_VERTEX ? triangle_height_scale(corner_height_scales(data), share.yz) : 1.0;
        if (displaced && (OBJECT.flags & FLAG_TRIPLANAR) != 0u) {
            RestTriangle rest = rest_triangle(data);
            vec3 b = rest.by_uv[0], c = rest.by_uv[1];
            float texels = max(max(length(b), length(c)), length(c - b)) * max(size.x, size.y);
            height = triplanar_height(rest, share.yz, height_map, max(height_spacing(texels), 0.0)) * scale_of_vertices;
        } else if (displaced) {
            TriangleTexcoord texcoord = triangle_texcoord(data);
            vec2 b = texcoord.by_uv[0] * size, c = texcoord.by_uv[1] * size;
            float texels = max(max(length(b), length(c)), length(c - b));
            vec2 at = texcoord.first + texcoord.by_uv * share.yz;
            float spacing = height_spacing(texels);
            height = whole_height(textureLod(height_map, at, max(spacing, 0.0)).x, at, spacing, scale_of_vertices);
        }
    }
    precise float scaled = height * OBJECT.displacement;
    precise vec3 displaced_position = position + normal * scaled;

    vec3 facing_here = facing[0] * share.x + facing[1] * share.y + facing[2] * share.z;
    out_patch_uv = share.yz;
    // The square is bounded below, since opposite normals may meet.
    out_normal = facing_here * inversesqrt(max(dot(facing_here, facing_here), 1e-12));
    out_patch = in_patch;
    gl_Position = VIEW.clip_from_world * vec4(displaced_position, 1.0);
    out_patch_uv_reached = out_patch_uv;
    out_window = window_position(gl_Position, VIEW.size);
}
