// Displaced triangles: the geometry pass draws them, the filter pass evaluates them again. Places are the shares of the second and the
// third corner.
#ifndef LEADR_GEOMETRY_TRIANGLE
#define LEADR_GEOMETRY_TRIANGLE

// On its edges a triangle is displaced along the directions of their places, which all triangles there share. From this share of each
// corner on it is displaced along its own normal, so that the relief of hard-edged faces stands upright on them.
const float OWN_NORMAL_FROM = 0.15;

float own_normal_share(const vec2 place) {
    float nearest = min(min(place.x, place.y), 1.0 - place.x - place.y);
    return clamp(nearest / OWN_NORMAL_FROM, 0.0, 1.0);
}

// The direction of displacement and its derivatives by the place.
struct TriangleNormal {
    vec3 normal;
    mat2x3 by_place;
};

// along: directions of the places of the corners; facing: normals of the corners. What the share changes by is left out of the
// derivatives: it is displaced to where the relief is, not shaded by it.
TriangleNormal triangle_normal(const vec3 along[3], const vec3 facing[3], const vec2 place) {
    float own = own_normal_share(place);
    vec3 first = mix(along[0], facing[0], own);
    mat2x3 turn = mat2x3(mix(along[1], facing[1], own) - first, mix(along[2], facing[2], own) - first);
    vec3 blend = first + turn * place;
    float per_length = inversesqrt(max(dot(blend, blend), 1e-12));
    TriangleNormal result;
    result.normal = blend * per_length;
    result.by_place = (turn - outerProduct(result.normal, result.normal * turn)) * per_length;
    return result;
}

#endif
