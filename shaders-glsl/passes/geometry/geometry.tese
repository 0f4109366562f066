#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"
#include "corner.glsl"
#include "edge.glsl"
#include "../reached.glsl"
#include "tile.glsl"
#include "../tiling.glsl"

layout(quads, fractional_odd_spacing, ccw) in;

// The options are constants, because drivers without divergent branches (lavapipe) run both sides of an `if`.
layout(constant_id = 1) const bool FLAT = false;      // the object is a plane with constant tangents
layout(constant_id = 2) const bool AT_TEXELS = false; // one vertex at the centre of each texel of the heights
layout(constant_id = 4) const bool BY_EXAMPLE = false;     // heights are tiled by example, so patches share texture coordinates

layout(location = 0) in vec3 in_position[];
layout(location = 1) in vec3 in_normal[];
layout(location = 2) in vec3 in_toward_next[];
layout(location = 3) in vec3 in_toward_previous[];
layout(location = 4) patch in uint in_patch;

layout(location = 0) out vec2 out_patch_uv; // position on the patch, [0, 1]^2; on a flat object, the texture coordinate
layout(location = 1) out vec3 out_normal; // displacement direction N
layout(location = 2) out flat uint out_patch;
layout(location = 3) out vec2 out_patch_uv_reached; // the same value as out_patch_uv
layout(location = 4) out vec3 out_window; // result of window_position

invariant gl_Position;

void main() {
    float u = gl_TessCoord.x, v = gl_TessCoord.y;
    PatchData data = patches[in_patch];
    bool displaced = (OBJECT.flags & FLAG_DISPLACED) != 0u;
    Boundary boundary = Boundary(vec3[](in_position[0], in_position[1], in_position[2], in_position[3]),
                                 vec3[](in_toward_next[0], in_toward_next[1], in_toward_next[2], in_toward_next[3]),
                                 vec3[](in_toward_previous[0], in_toward_previous[1], in_toward_previous[2], in_toward_previous[3]));
    vec3 position = FLAT ? mix(mix(in_position[0], in_position[1], u), mix(in_position[3], in_position[2], u), v)
                         : patch_point(boundary, u, v).position;
    precise vec3 normal = patch_normal(vec3[](in_normal[0], in_normal[1], in_normal[2], in_normal[3]), u, v).normal;
    PatchTexcoord texcoord = patch_texcoord(data, u, v);
    vec2 patch_uv = vec2(u, v);

    float height = 0.0;
    // The position and the level of detail for the lookup of heights tiled by example.
    precise vec2 tiled_at = texcoord.at;
    float tiled_lod = 0.0;
    float spacing = 0.0; // level of detail of the heights at the spacing of the vertices, which may be negative
    precise float scale_of_vertices = 1.0;
    if (SCALED_BY_VERTEX) {
        scale_of_vertices = quad_height_scale(corner_height_scales(data), patch_uv);
    }
    // On the boundary, everything is computed from the edge's own data, in the edge's own direction (from its lower vertex). Both patches
    // compute the same bits, even if their texture coordinates differ, so no crack can open.
    bool on_boundary = u == 0.0 || u == 1.0 || v == 0.0 || v == 1.0;
    if (AT_TEXELS) {
        // All values depend on the texel index only, so patches match. Fractional spacing creates vertices half-way between texels, and all
        // of these move to the same side.
        vec2 size = vec2(textureSize(height_map, 0));
        vec2 middle = (floor(texcoord.at * size + 0.49) + 0.5) / size, moved = middle - texcoord.at;
        patch_uv += inverse(mat2(texcoord.du, texcoord.dv)) * moved;
        texcoord.at = middle;
        position = vec3(middle * OBJECT.texel_repeat, 0.0);
        normal = vec3(0.0, 0.0, 1.0);
        tiled_at = middle;
        height = BY_EXAMPLE ? 0.0 : textureLod(height_map, middle, 0.0).x;
    } else if (!on_boundary && displaced) {
        // The height is filtered to about the vertex spacing. Shading accounts for bumps that are too fine for the geometry.
        vec2 factor = vec2(gl_TessLevelInner[0], gl_TessLevelInner[1]);
        vec2 texels = vec2(textureSize(height_map, 0)) * vec2(length(texcoord.du), length(texcoord.dv));
        spacing = log2(max(texels.x / factor.x, texels.y / factor.y)) - FINER;
        float lod = max(spacing, 0.0);
        tiled_lod = lod;
        height = BY_EXAMPLE ? 0.0 : textureLod(height_map, clamp_to_tile(texcoord.at, patch_tile(data), lod, textureSize(height_map, 0)), lod).x;
    }
    if (on_boundary && !AT_TEXELS) {
        int side = v == 0.0 ? 0 : (u == 1.0 ? 1 : (v == 1.0 ? 2 : 3));
        float t = side == 0 ? u : (side == 1 ? v : (side == 2 ? 1.0 - u : 1.0 - v));
        int from = side, to = (side + 1) & 3;
        uint edge = data.edges[side] >> 1;
        vec3 a = in_position[from], b = in_toward_next[from], c = in_toward_previous[to], d = in_position[to];
        vec3 na = in_normal[from], nb = in_normal[to];
        if ((data.edges[side] & 1u) != 0u) {
            t = 1.0 - t;
            vec3 swap = a; a = d; d = swap;
            swap = b; b = c; c = swap;
            swap = na; na = nb; nb = swap;
            from = to;
            to = side;
        }
        if (FLAT) {
            precise vec3 between = a * (1.0 - t) + d * t;
            position = between;
        } else {
            position = cubic(a, b, c, d, t);
        }
        precise vec3 along = na * (1.0 - t) + nb * t;
        normal = displacement_normal(along);
        if (BY_EXAMPLE) {
            vec2 corners[4] = vec2[](data.mapping[0].xy, data.mapping[0].zw, data.mapping[1].zw, data.mapping[1].xy);
            vec2 first = corners[from], last = corners[to];
            precise vec2 on_edge = first * (1.0 - t) + last * t;
            tiled_at = t == 0.0 ? first : (t == 1.0 ? last : on_edge);
            float segment = length((last - first) * vec2(textureSize(height_map, 0))) / 64.0;
            float along_edge = max(log2(segment) + edge_lod(edge), 0.0);
            tiled_lod = t == 0.0 ? vertex_height(data.vertices[from]) : (t == 1.0 ? vertex_height(data.vertices[to]) : along_edge);
            if (SCALED_BY_VERTEX) {
                scale_of_vertices = vertices[data.vertices[from]].facing.w * (1.0 - t) + vertices[data.vertices[to]].facing.w * t;
            }
        } else if (displaced) {
            height = t == 0.0 ? vertex_height(data.vertices[from])
                   : (t == 1.0 ? vertex_height(data.vertices[to]) : edge_height(edge, t));
        }
    }
    if (BY_EXAMPLE) {
        height = tiled_height(height_map, OBJECT.flags, tiled_at + OBJECT.shift, tiled_lod);
        height = whole_height(height, tiled_at, tiled_lod, scale_of_vertices);
    } else if (AT_TEXELS || !on_boundary) {
        // The heights of edges are already whole.
        height = whole_height(height, texcoord.at, spacing, scale_of_vertices);
    }
    precise float scaled = height * OBJECT.displacement;
    precise vec3 displaced_position = position + normal * scaled;

    out_patch_uv = (OBJECT.flags & FLAG_FLAT) != 0u ? texcoord.at : patch_uv;
    out_normal = normal;
    out_patch = in_patch;
    gl_Position = VIEW.clip_from_world * vec4(displaced_position, 1.0);
    out_patch_uv_reached = out_patch_uv;
    out_window = window_position(gl_Position, VIEW.size);
}
