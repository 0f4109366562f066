// Displaced triangles. The geometry pass draws them, and the filter pass evaluates them again. Positions are the barycentric weights of the
// second and third corner.
#ifndef LEADR_GEOMETRY_TRIANGLE
#define LEADR_GEOMETRY_TRIANGLE

// On its edges, a triangle is displaced along directions shared by all adjacent triangles. Where every corner has at least this barycentric
// weight, it is displaced along its own normal, so that the relief of hard-edged faces stands upright.
const float OWN_NORMAL_FROM = 0.15;

float own_normal_share(const vec2 patch_uv) {
    float nearest = min(min(patch_uv.x, patch_uv.y), 1.0 - patch_uv.x - patch_uv.y);
    return clamp(nearest / OWN_NORMAL_FROM, 0.0, 1.0);
}

// The displacement direction, and its derivatives by position.
struct TriangleNormal {
    vec3 normal;
    mat2x3 by_uv;
};

// Evaluates the displacement direction. along has the shared directions at the corners, and facing has the normals of the corners. The
// derivatives leave out the change of the weight, which affects the displaced position but not the shading.
TriangleNormal triangle_normal(const vec3 along[3], const vec3 facing[3], const vec2 patch_uv) {
    float own = own_normal_share(patch_uv);
    vec3 first = mix(along[0], facing[0], own);
    mat2x3 normal_change = mat2x3(mix(along[1], facing[1], own) - first, mix(along[2], facing[2], own) - first);
    vec3 blend = first + normal_change * patch_uv;
    float per_length = inversesqrt(max(dot(blend, blend), 1e-12));
    TriangleNormal result;
    result.normal = blend * per_length;
    result.by_uv = (normal_change - outerProduct(result.normal, result.normal * normal_change)) * per_length;
    return result;
}

#endif
