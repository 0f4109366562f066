#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"
#include "tile.glsl"

layout(quads, fractional_odd_spacing, ccw) in;

layout(location = 0) in vec3 in_position[];
layout(location = 1) in vec3 in_normal[];
layout(location = 2) in vec3 in_toward_next[];
layout(location = 3) in vec3 in_toward_previous[];
layout(location = 4) patch in uint in_patch;

layout(location = 0) out vec3 out_normal;      // displacement direction N
layout(location = 1) out vec3 out_tangent_s;   // dX/ds + h dN/ds: tangents of the offset surface by texture coordinate
layout(location = 2) out vec3 out_tangent_t;
layout(location = 3) out vec2 out_texcoord;
layout(location = 4) out vec4 out_color;
layout(location = 5) out float out_accessibility;
layout(location = 6) out flat uint out_patch;

invariant gl_Position;

vec3 cubic(vec3 a, vec3 b, vec3 c, vec3 d, float t) {
    precise float s = 1.0 - t;
    precise float wa = s * s * s, wb = 3.0 * s * s * t, wc = 3.0 * s * t * t, wd = t * t * t;
    precise vec3 sum = a * wa + b * wb + c * wc + d * wd;
    return sum;
}

vec3 cubic_derivative(vec3 a, vec3 b, vec3 c, vec3 d, float t) {
    float s = 1.0 - t;
    return 3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c));
}

// Heights are read so many levels below the one whose texels are as wide as vertices are apart: trilinear lookups and the
// straight lines between vertices widen them again, and relief that the geometry lacks does not turn toward the viewer either
// (docs/measurements/outside.md).
const float FINER = 1.0;

float edge_height_at_level(uint edge, int level, float t) {
    int segments = 64 >> level;
    int offset = 128 - (128 >> level) + level; // samples of the finer levels: sum of (64 >> l) + 1
    float x = t * float(segments);
    int i = min(int(x), segments - 1);
    uint base = edge * uint(EDGE_STRIDE) + uint(offset + i);
    precise float fraction = x - float(i);
    precise float height = edge_heights[base] * (1.0 - fraction) + edge_heights[base + 1u] * fraction;
    return height;
}

float edge_height(uint edge, float t) {
    float lod = clamp(log2(64.0 / edge_factors[edge]) - FINER, 0.0, float(EDGE_LEVELS - 1));
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    precise float height =
        edge_height_at_level(edge, level, t) * (1.0 - fraction) + edge_height_at_level(edge, level + 1, t) * fraction;
    return height;
}

float vertex_height(uint vertex) {
    float lod = clamp(vertices[vertex].normal.w - FINER, 0.0, float(EDGE_LEVELS - 1));
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    uint base = vertex * uint(EDGE_LEVELS) + uint(level);
    precise float height = vertex_heights[base] * (1.0 - fraction) + vertex_heights[base + 1u] * fraction;
    return height;
}

void main() {
    float u = gl_TessCoord.x, v = gl_TessCoord.y;
    vec3 p0 = in_position[0], p1 = in_position[1], p2 = in_position[2], p3 = in_position[3];
    PatchData data = patches[in_patch];
    bool displaced = (object.flags & FLAG_DISPLACED) != 0u;

    // Boundary cubics: c0 (v=0), c1 (v=1) along u; d0 (u=0), d1 (u=1) along v.
    vec3 c0 = cubic(p0, in_toward_next[0], in_toward_previous[1], p1, u);
    vec3 c1 = cubic(p3, in_toward_previous[3], in_toward_next[2], p2, u);
    vec3 d0 = cubic(p0, in_toward_previous[0], in_toward_next[3], p3, v);
    vec3 d1 = cubic(p1, in_toward_next[1], in_toward_previous[2], p2, v);
    // The Coons patch of its boundary: the same bicubic surface as src/render/surfaces/patch.rs.
    vec3 position = mix(c0, c1, v) + mix(d0, d1, u) - mix(mix(p0, p1, u), mix(p3, p2, u), v);
    vec3 du = mix(cubic_derivative(p0, in_toward_next[0], in_toward_previous[1], p1, u),
                  cubic_derivative(p3, in_toward_previous[3], in_toward_next[2], p2, u), v)
            + d1 - d0 - mix(p1 - p0, p2 - p3, v);
    vec3 dv = mix(cubic_derivative(p0, in_toward_previous[0], in_toward_next[3], p3, v),
                  cubic_derivative(p1, in_toward_next[1], in_toward_previous[2], p2, v), u)
            + c1 - c0 - mix(p3 - p0, p2 - p1, u);

    vec3 bottom = mix(in_normal[0], in_normal[1], u), top = mix(in_normal[3], in_normal[2], u);
    vec3 blend = mix(bottom, top, v);
    float inverse_length = inversesqrt(dot(blend, blend));
    precise vec3 normal = blend * inverse_length;
    vec3 normal_du = mix(in_normal[1] - in_normal[0], in_normal[2] - in_normal[3], v) * inverse_length;
    vec3 normal_dv = (top - bottom) * inverse_length;
    normal_du -= normal * dot(normal, normal_du);
    normal_dv -= normal * dot(normal, normal_dv);

    vec2 t0 = data.texcoord_01.xy, t1 = data.texcoord_01.zw, t3 = data.texcoord_23.xy, t2 = data.texcoord_23.zw;
    vec2 texcoord = mix(mix(t0, t1, u), mix(t3, t2, u), v);
    vec2 texcoord_du = mix(t1 - t0, t2 - t3, v), texcoord_dv = mix(t3 - t0, t2 - t1, u);

    float height = 0.0;
    bool at_texels = displaced && view.texel_grid.x > 0.0;
    // On the boundary everything is computed from the edge's own data, in the edge's own direction (from its lower
    // vertex), so that both patches compute the same bits and no crack can open, whatever their texture coordinates are.
    bool on_boundary = u == 0.0 || u == 1.0 || v == 0.0 || v == 1.0;
    if (at_texels) {
        // Everything follows from the number of the texel, so patches agree. Vertices half-way between texels, which fractional
        // spacing makes, all go to the same side.
        vec2 size = vec2(textureSize(height_map, 0));
        texcoord = (floor(texcoord * size + 0.49) + 0.5) / size;
        position = vec3(texcoord * view.texel_grid.x, 0.0);
        normal = vec3(0.0, 0.0, 1.0);
        height = textureLod(height_map, texcoord, 0.0).x;
    } else if (on_boundary) {
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
        position = cubic(a, b, c, d, t);
        precise vec3 along = na * (1.0 - t) + nb * t;
        precise float square = along.x * along.x + along.y * along.y + along.z * along.z;
        normal = along / sqrt(square);
        if (displaced) {
            height = t == 0.0 ? vertex_height(data.vertices[from])
                   : (t == 1.0 ? vertex_height(data.vertices[to]) : edge_height(edge, t));
        }
    } else if (displaced) {
        // The height filtered to about the spacing of the vertices: bumps too fine for the geometry are left to the shading.
        vec2 factor = vec2(gl_TessLevelInner[0], gl_TessLevelInner[1]);
        vec2 texels = vec2(textureSize(height_map, 0)) * vec2(length(texcoord_du), length(texcoord_dv));
        float lod = max(log2(max(texels.x / factor.x, texels.y / factor.y)) - FINER, 0.0);
        height = textureLod(height_map, clamp_to_tile(texcoord, data.tile, lod, textureSize(height_map, 0)), lod).x;
    }
    precise float scaled = height * object.height_scale;
    precise vec3 displaced_position = position + normal * scaled;

    du += normal_du * scaled;
    dv += normal_dv * scaled;
    // Chain rule to derivatives by texture coordinate; a degenerate chart falls back to the patch's own parameter.
    float det = texcoord_du.x * texcoord_dv.y - texcoord_du.y * texcoord_dv.x;
    if (abs(det) > 1e-20) {
        out_tangent_s = (du * texcoord_dv.y - dv * texcoord_du.y) / det;
        out_tangent_t = (dv * texcoord_du.x - du * texcoord_dv.x) / det;
    } else {
        out_tangent_s = du;
        out_tangent_t = dv;
    }
    out_normal = normal;
    out_texcoord = texcoord;
    uvec4 corner = data.vertices;
    out_color = mix(mix(vertices[corner.x].color, vertices[corner.y].color, u),
                    mix(vertices[corner.w].color, vertices[corner.z].color, u), v);
    out_accessibility = mix(mix(vertices[corner.x].position.w, vertices[corner.y].position.w, u),
                            mix(vertices[corner.w].position.w, vertices[corner.z].position.w, u), v);
    out_patch = in_patch;
    gl_Position = view.clip_from_world * vec4(displaced_position, 1.0);
}
