// Heights along the edges of patches. The heights are identical for all patches at an edge, even if their texture coordinates differ.
#ifndef LEADR_GEOMETRY_EDGE
#define LEADR_GEOMETRY_EDGE

float edge_height_at_level(const uint edge, const int level, const float t) {
    int segments = 64 >> level;
    int offset = 128 - (128 >> level) + level; // number of samples in the finer levels: the sum of (64 >> l) + 1
    float x = t * float(segments);
    int i = min(int(x), segments - 1);
    uint base = edge * uint(EDGE_STRIDE) + uint(offset + i);
    precise float fraction = x - float(i);
    precise float height = edge_heights[base] * (1.0 - fraction) + edge_heights[base + 1u] * fraction;
    return height;
}

// Returns the level of the heights along an edge. Level 0 has 64 segments.
float edge_lod(const uint edge) {
    return clamp(log2(64.0 / edge_factors[edge]) - FINER, 0.0, float(EDGE_LEVELS - 1));
}

float edge_height(const uint edge, const float t) {
    float lod = edge_lod(edge);
    int level = min(int(lod), EDGE_LEVELS - 2);
    float fraction = lod - float(level);
    precise float height =
        edge_height_at_level(edge, level, t) * (1.0 - fraction) + edge_height_at_level(edge, level + 1, t) * fraction;
    return height;
}

#endif
