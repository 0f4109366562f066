// The point-normal patch of crates/leadr-render/src/surfaces/patch.rs. The geometry pass draws this patch, and the filter pass evaluates it
// at the visible position.
#ifndef LEADR_GEOMETRY_PATCH
#define LEADR_GEOMETRY_PATCH
#include "../constants.glsl"

struct Vertex {
    vec4 position; // xyz metres; w: ambient accessibility
    vec4 normal;   // xyz: unit displacement direction; w: level of detail of the heights at this vertex
    vec4 color;    // rgb linear albedo; a: Beckmann roughness alpha
    vec4 facing;   // xyz: unit normal for the shading of triangles; w: factor on the height scale
};

struct PatchData {
    uvec4 vertices;   // at the corners (0,0) (1,0) (1,1) (0,1)
    uvec4 edges;      // edge index << 1, plus 1 if the patch runs along the edge backwards
    vec4 mapping[3]; // rest_triangle if the relief is projected along the axes, else patch_texcoord or triangle_texcoord; and patch_tile
};

// Texture coordinates of a triangle in the images of its material. Each CHART_ constant has three corners.
struct TriangleCharts {
    vec2 corners[3u * CHARTS];
};

layout(std430) readonly buffer Vertices { Vertex vertices[]; };
layout(set = 2, std430) readonly buffer Patches { PatchData patches[]; };

// The control points of the four boundary curves.
struct Boundary {
    vec3 position[4];
    vec3 toward_next[4]; // inner Bezier points on the two boundaries at each corner
    vec3 toward_previous[4];
};

// Returns the inner Bezier point next to `a` on the boundary from `a` to `b`. The result is precise, so both patches at an edge compute the
// same bits.
vec3 edge_point(const vec3 a, const vec3 normal_a, const vec3 b) {
    precise vec3 chord = (b - a) / 3.0;
    precise float drop = chord.x * normal_a.x + chord.y * normal_a.y + chord.z * normal_a.z;
    precise vec3 point = a + chord - normal_a * drop;
    return point;
}

vec3 cubic(const vec3 a, const vec3 b, const vec3 c, const vec3 d, const float t) {
    precise float s = 1.0 - t;
    precise float wa = s * s * s, wb = 3.0 * s * s * t, wc = 3.0 * s * t * t, wd = t * t * t;
    precise vec3 sum = a * wa + b * wb + c * wc + d * wd;
    return sum;
}

vec3 cubic_derivative(const vec3 a, const vec3 b, const vec3 c, const vec3 d, const float t) {
    float s = 1.0 - t;
    return 3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c));
}

struct PatchPoint {
    vec3 position;
    vec3 du; // derivative of the position by the patch's parameter u
    vec3 dv;
};

// The Coons patch of the boundary. The curves are the cubics c0 (v=0), c1 (v=1) along u; d0 (u=0), d1 (u=1) along v.
PatchPoint patch_point(const Boundary b, const float u, const float v) {
    vec3 p0 = b.position[0], p1 = b.position[1], p2 = b.position[2], p3 = b.position[3];
    vec3 c0 = cubic(p0, b.toward_next[0], b.toward_previous[1], p1, u);
    vec3 c1 = cubic(p3, b.toward_previous[3], b.toward_next[2], p2, u);
    vec3 d0 = cubic(p0, b.toward_previous[0], b.toward_next[3], p3, v);
    vec3 d1 = cubic(p1, b.toward_next[1], b.toward_previous[2], p2, v);
    PatchPoint point;
    point.position = mix(c0, c1, v) + mix(d0, d1, u) - mix(mix(p0, p1, u), mix(p3, p2, u), v);
    point.du = mix(cubic_derivative(p0, b.toward_next[0], b.toward_previous[1], p1, u),
                   cubic_derivative(p3, b.toward_previous[3], b.toward_next[2], p2, u), v)
             + d1 - d0 - mix(p1 - p0, p2 - p3, v);
    point.dv = mix(cubic_derivative(p0, b.toward_previous[0], b.toward_next[3], p3, v),
                   cubic_derivative(p1, b.toward_next[1], b.toward_previous[2], p2, v), u)
             + c1 - c0 - mix(p3 - p0, p2 - p1, u);
    return point;
}

// The displacement direction, and its derivatives by the patch's parameters.
struct PatchNormal {
    vec3 normal;
    vec3 du;
    vec3 dv;
};

PatchNormal patch_normal(const vec3 n[4], const float u, const float v) {
    vec3 bottom = mix(n[0], n[1], u), top = mix(n[3], n[2], u);
    vec3 blend = mix(bottom, top, v);
    float inverse_length = inversesqrt(dot(blend, blend));
    PatchNormal result;
    result.normal = blend * inverse_length;
    result.du = mix(n[1] - n[0], n[2] - n[3], v) * inverse_length;
    result.dv = (top - bottom) * inverse_length;
    result.du -= result.normal * dot(result.normal, result.du);
    result.dv -= result.normal * dot(result.normal, result.dv);
    return result;
}

struct PatchTexcoord {
    vec2 at;
    vec2 du;
    vec2 dv;
};

PatchTexcoord patch_texcoord(const PatchData data, const float u, const float v) {
    vec2 t0 = data.mapping[0].xy, t1 = data.mapping[0].zw, t3 = data.mapping[1].xy, t2 = data.mapping[1].zw;
    return PatchTexcoord(mix(mix(t0, t1, u), mix(t3, t2, u), v), mix(t1 - t0, t2 - t3, v), mix(t3 - t0, t2 - t1, u));
}

// The texture coordinate on a triangle at its corner 0, and the derivatives by the barycentric weights of the other two corners.
struct TriangleTexcoord {
    vec2 first;
    mat2 by_uv;
};

TriangleTexcoord triangle_texcoord(const PatchData data) {
    vec2 first = data.mapping[0].xy;
    return TriangleTexcoord(first, mat2(data.mapping[0].zw - first, data.mapping[1].xy - first));
}

// Returns the texture coordinates in one image of the material.
TriangleTexcoord charted_texcoord(const TriangleCharts charts, const uint chart) {
    vec2 first = charts.corners[3u * chart];
    return TriangleTexcoord(first, mat2(charts.corners[3u * chart + 1u] - first, charts.corners[3u * chart + 2u] - first));
}

// Returns the bounds of the filter taps in texture space, as min.xy and max.xy.
vec4 patch_tile(const PatchData data) {
    return data.mapping[2];
}

#endif
