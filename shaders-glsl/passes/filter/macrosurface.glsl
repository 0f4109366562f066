// The smooth surface that carries the relief. It is evaluated once per pixel, at the position that the geometry pass stored.
#ifndef LEADR_FILTER_MACROSURFACE
#define LEADR_FILTER_MACROSURFACE

#include "../geometry/patch.glsl"
#include "../geometry/triangle.glsl"

struct Macrosurface {
    vec3 normal;            // displacement direction N; for a triangle, its shading normal on the visible side
    mat2x3 by_uv;        // derivatives of the offset surface X + h N by position
    mat2x3 normal_by_uv; // derivatives of its normal by position
    mat2 texcoord_by_uv;
    vec3 tangent_s;         // dX/ds + h dN/ds: tangents of the offset surface by texture coordinate
    vec3 tangent_t;
    vec2 texcoord;
    float height;           // height of the visible point, as displaced by the geometry pass
    vec4 color;
    float accessibility;
    float slopes;           // factor on the slopes of the maps: -1 for back faces, 0 where the chart has no area
};

// Returns the position on a patch, which the geometry pass does not store for a flat object.
vec2 position_on_patch(const PatchData data, const vec2 patch_uv) {
    if (!FLAT) {
        return patch_uv;
    }
    PatchTexcoord corner = patch_texcoord(data, 0.0, 0.0);
    return inverse(mat2(corner.du, corner.dv)) * (patch_uv - corner.at);
}

// Evaluates the macrosurface. patch_uv is the value stored by the geometry pass, reach is the vector from the viewer to the visible point,
// and behind is whether the visible side is a triangle's back face.
Macrosurface macrosurface_at(const uint index, const vec2 patch_uv, const vec3 reach, const bool behind) {
    Macrosurface surface;
    surface.slopes = 1.0;
    surface.color = OBJECT.color;
    surface.accessibility = OBJECT.tangent_t.w;
    PatchData data;
    if (!FLAT || !PLAIN) {
        data = patches[index];
    }
    if (FLAT) {
        surface.tangent_s = OBJECT.tangent_s.xyz;
        surface.tangent_t = OBJECT.tangent_t.xyz;
        surface.normal = normalize(cross(surface.tangent_s, surface.tangent_t)) * OBJECT.tangent_s.w;
        surface.by_uv = mat2x3(surface.tangent_s, surface.tangent_t);
        surface.normal_by_uv = mat2x3(0.0);
        surface.texcoord_by_uv = mat2(1.0);
        surface.texcoord = patch_uv;
        surface.height = dot(reach, surface.normal) + OBJECT.viewer_above;
    } else if (TRIANGLES) {
        Vertex a = vertices[data.vertices[0]], b = vertices[data.vertices[1]], c = vertices[data.vertices[3]];
        surface.by_uv = mat2x3(b.position.xyz - a.position.xyz, c.position.xyz - a.position.xyz);
        mat2x3 normal_change = mat2x3(b.facing.xyz - a.facing.xyz, c.facing.xyz - a.facing.xyz);
        vec3 normal = a.facing.xyz + normal_change * patch_uv;
        // The back of a surface faces the other way, so bumps become pits.
        float side = (behind ? -1.0 : 1.0) * inversesqrt(max(dot(normal, normal), 1e-12));
        surface.normal = normal * side;
        surface.normal_by_uv = (normal_change - outerProduct(surface.normal, surface.normal * normal_change)) * side;
        surface.height = 0.0;
        if (DISPLACED) {
            TriangleNormal along = triangle_normal(vec3[3](a.normal.xyz, b.normal.xyz, c.normal.xyz),
                                                   vec3[3](a.facing.xyz, b.facing.xyz, c.facing.xyz), patch_uv);
            surface.height = dot(reach + (VIEW.eye.xyz - a.position.xyz - surface.by_uv * patch_uv), along.normal);
            surface.by_uv += along.by_uv * surface.height;
        }
        if (TRIPLANAR) {
            // On a flat object, the positions are the texture coordinates.
            surface.texcoord_by_uv = mat2(1.0);
            surface.texcoord = patch_uv;
        } else {
            TriangleTexcoord texcoord = triangle_texcoord(data);
            surface.texcoord_by_uv = texcoord.by_uv;
            surface.texcoord = texcoord.first + texcoord.by_uv * patch_uv;
        }
        float det = determinant(surface.texcoord_by_uv);
        bool charted = abs(det) > 1e-20;
        surface.slopes = charted ? (behind ? -1.0 : 1.0) : 0.0;
        mat2x3 tangents = charted ? surface.by_uv * inverse(surface.texcoord_by_uv) : surface.by_uv;
        // Slopes are relative to the interpolated vertex normal, not to the normal of the triangle, so that a coarse mesh looks smooth.
        surface.tangent_s = tangents[0] - surface.normal * dot(surface.normal, tangents[0]);
        surface.tangent_t = tangents[1] - surface.normal * dot(surface.normal, tangents[1]);
    } else {
        vec3 position[4], normals[4], toward_next[4], toward_previous[4];
        for (int i = 0; i < 4; ++i) {
            Vertex vertex = vertices[data.vertices[i]];
            position[i] = vertex.position.xyz;
            normals[i] = vertex.normal.xyz;
        }
        for (int i = 0; i < 4; ++i) {
            toward_next[i] = edge_point(position[i], normals[i], position[(i + 1) & 3]);
            toward_previous[i] = edge_point(position[i], normals[i], position[(i + 3) & 3]);
        }
        PatchPoint point = patch_point(Boundary(position, toward_next, toward_previous), patch_uv.x, patch_uv.y);
        PatchNormal normal = patch_normal(normals, patch_uv.x, patch_uv.y);
        surface.height = DISPLACED ? dot(reach + (VIEW.eye.xyz - point.position), normal.normal) : 0.0;
        surface.normal = normal.normal;
        surface.normal_by_uv = mat2x3(normal.du, normal.dv);
        surface.by_uv = mat2x3(point.du, point.dv) + surface.normal_by_uv * surface.height;
        PatchTexcoord texcoord = patch_texcoord(data, patch_uv.x, patch_uv.y);
        surface.texcoord = texcoord.at;
        surface.texcoord_by_uv = mat2(texcoord.du, texcoord.dv);
        // The chain rule gives the derivatives. If the chart is degenerate, the patch's own parameters replace it.
        float det = determinant(surface.texcoord_by_uv);
        mat2x3 tangents = abs(det) > 1e-20 ? surface.by_uv * inverse(surface.texcoord_by_uv) : surface.by_uv;
        surface.tangent_s = tangents[0];
        surface.tangent_t = tangents[1];
    }
    if (!PLAIN) {
        vec2 at = position_on_patch(data, patch_uv);
        uvec4 corner = data.vertices;
        if (TRIANGLES) {
            vec4 first = vertices[corner.x].color;
            surface.color = first + (vertices[corner.y].color - first) * at.x + (vertices[corner.w].color - first) * at.y;
            surface.accessibility = 1.0;
            return surface;
        }
        surface.color = mix(mix(vertices[corner.x].color, vertices[corner.y].color, at.x),
                            mix(vertices[corner.w].color, vertices[corner.z].color, at.x), at.y);
        surface.accessibility = mix(mix(vertices[corner.x].position.w, vertices[corner.y].position.w, at.x),
                                    mix(vertices[corner.w].position.w, vertices[corner.z].position.w, at.x), at.y);
    }
    return surface;
}

// Returns the derivatives of the position by x and y of the image. The derivatives are taken on the tangent plane, which changes smoothly,
// because derivatives on triangles would be discontinuous. At silhouettes, the plane leaves the surface within the pixel. There the macro
// normal rotates away as fast as the plane recedes, which limits the derivatives. ray has length 1 along the view axis, and along is the
// distance along this axis. pixel is the step from pixel to pixel in normalised device coordinates.
mat2 pixel_footprint(const Macrosurface surface, const vec3 ray, const float along, const vec2 pixel) {
    vec3 du = surface.by_uv[0], dv = surface.by_uv[1];
    vec3 normal = cross(du, dv);
    float square = max(dot(normal, normal), 1e-30);
    vec3 by_u = cross(dv, normal) / square, by_v = cross(normal, du) / square;
    vec3 x = VIEW.ray_x.xyz * (pixel.x * along), y = VIEW.ray_y.xyz * (pixel.y * along);
    float facing = dot(normal, ray), nx = dot(normal, x), ny = dot(normal, y);
    float least = 1e-4 * sqrt(square * dot(ray, ray));
    if (!FLAT) {
        // `normal_change` is the rotation of the normal across the footprint, and `facing` is the cosine between unit normal and ray. The
        // surface hidden behind the pixel centre rotates by about half as much.
        vec3 normal_change = surface.normal_by_uv * vec2(dot(ray, by_u), dot(ray, by_v));
        least = max(least, sqrt(0.5 * length(normal_change) * length(vec2(nx, ny)) * sqrt(square * dot(ray, ray))));
    }
    facing = facing < 0.0 ? min(facing, -least) : max(facing, least);
    x -= ray * (nx / facing);
    y -= ray * (ny / facing);
    return mat2(dot(x, by_u), dot(x, by_v), dot(y, by_u), dot(y, by_v));
}

#endif
