// Computes normals and heights at the corners of patches. All passes compute them in the same way, so that no crack opens between divided
// and undivided patches.
#ifndef LEADR_GEOMETRY_CORNER
#define LEADR_GEOMETRY_CORNER

// Heights are read this many levels below the level whose texels match the vertex spacing, because trilinear lookups and the linear
// interpolation between vertices widen them again. Geometry without fine relief also lacks the tilt of visible bumps toward the viewer
// (docs/measurements/outside.md).
const float FINER = 1.0;

// Returns the height of a vertex. For a map tiled by example, it returns the level of detail of the lookup instead.
float vertex_height(const uint vertex) {
    float lod = clamp(vertices[vertex].normal.w - FINER, 0.0, float(EDGE_LEVELS - 1));
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    uint base = vertex * uint(EDGE_LEVELS) + uint(level);
    precise float height = vertex_heights[base] * (1.0 - fraction) + vertex_heights[base + 1u] * fraction;
    return height;
}

// The result is precise, so every patch at an edge or corner computes the same bits. Where opposite directions meet, there is no
// displacement.
vec3 displacement_normal(const vec3 along) {
    precise float square = along.x * along.x + along.y * along.y + along.z * along.z;
    precise vec3 normal = along / sqrt(max(square, 1e-12));
    return normal;
}

#endif
