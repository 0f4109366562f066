// Heights at the corners of patches.
#ifndef LEADR_GEOMETRY_CORNER
#define LEADR_GEOMETRY_CORNER

// Heights are read so many levels below the one whose texels are as wide as vertices are apart: trilinear lookups and the
// straight lines between vertices widen them again, and relief that the geometry lacks does not turn toward the viewer either
// (docs/measurements/outside.md).
const float FINER = 1.0;

float vertex_height(uint vertex) {
    float lod = clamp(vertices[vertex].normal.w - FINER, 0.0, float(EDGE_LEVELS - 1));
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    uint base = vertex * uint(EDGE_LEVELS) + uint(level);
    precise float height = vertex_heights[base] * (1.0 - fraction) + vertex_heights[base + 1u] * fraction;
    return height;
}

#endif
