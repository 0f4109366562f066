// Normals and heights at the corners of patches, by the same steps wherever they are worked out, so that no crack opens between
// patches that are divided and those that are not.
#ifndef LEADR_GEOMETRY_CORNER
#define LEADR_GEOMETRY_CORNER

// Heights are read so many levels below the one whose texels are as wide as vertices are apart: trilinear lookups and the
// straight lines between vertices widen them again, and relief that the geometry lacks does not turn toward the viewer either
// (docs/measurements/outside.md).
const float FINER = 1.0;

// Of a map that is shown without its repeats, the level of detail in which it is looked up there instead.
float vertex_height(const uint vertex) {
    float lod = clamp(vertices[vertex].normal.w - FINER, 0.0, float(EDGE_LEVELS - 1));
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    uint base = vertex * uint(EDGE_LEVELS) + uint(level);
    precise float height = vertex_heights[base] * (1.0 - fraction) + vertex_heights[base + 1u] * fraction;
    return height;
}

// Precise: every patch at an edge or corner gets the same bits. Where opposite directions meet, nothing is displaced.
vec3 displacement_normal(const vec3 along) {
    precise float square = along.x * along.x + along.y * along.y + along.z * along.z;
    precise vec3 normal = along / sqrt(max(square, 1e-12));
    return normal;
}

#endif
