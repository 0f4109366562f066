#ifndef LEADR_SLOPE_NODES_GLSL
#define LEADR_SLOPE_NODES_GLSL

#include "../facets/beckmann_sampling.glsl"
#include "../facets/projected_area.glsl"
#include "diffuse.glsl"

// Placements of the N x N samples of a pixel. crates/leadr-reflectance/src/integrals/slope_nodes.rs has the sources. Once per pixel
//     SlopeNodes nodes = slope_nodes(placement, wo, m, S, n);
// then for each row j and each k in 0..n-1
//     float row = node_row(nodes, j);
//     SlopeNode node = slope_node(nodes, wo, row, k);
// and once
//     SlopeNode node = artificial_node(nodes, wo);
// Estimators divide by the sum of the weights. A sample of weight 0 is left out.

const int LEADR_NODES_GRID = 0;    // the grid of the paper
const int LEADR_NODES_PRUNED = 1;  // the grid without its lightest nodes (Jaeckel 2005)
const int LEADR_NODES_MICRONORMAL = 2; // the grid and the artificial micronormal (LEADR supplement 3.7)
const int LEADR_NODES_NORMALS = 3; // visible normals at u = j/N (thesis 3.4)
const int LEADR_NODES_CENTRED = 4; // visible normals at u = (j + 1/2)/N

struct SlopeNodes {
    int placement;
    int n;
    float lambda;
    vec2 m;
    vec3 cholesky;
    vec2 along;     // azimuth of the viewer, in the space where the slopes are isotropic
    float nu;       // projected area of the mesosurface, in units of the spread of slopes along this azimuth
    float area;     // visible area
    float farthest; // largest square of the distance of a pruned node from the mean
};

struct SlopeNode {
    vec2 slope;
    float weight; // contains the visible area of the facet
    float cell;   // area of slopes that the sample stands for, in units of the determinant of the Cholesky factor
};

SlopeNodes slope_nodes(const int placement, const vec3 wo, const vec2 m, const vec3 S, const int n) {
    SlopeNodes nodes;
    nodes.placement = placement;
    nodes.n = n;
    nodes.lambda = grid_lambda(n);
    nodes.m = placement >= LEADR_NODES_MICRONORMAL ? m : face_viewer(wo, m, S, nodes.lambda);
    nodes.cholesky = slope_cholesky(S);
    vec2 t = vec2(nodes.cholesky.x * wo.x + nodes.cholesky.y * wo.y, nodes.cholesky.z * wo.y);
    float spread = length(t);
    nodes.along = spread > 1e-18 ? t / spread : vec2(1.0, 0.0);
    nodes.nu = clamp(meso_area(wo, m) / max(spread, 1e-18), -1e15, 1e15);
    nodes.area = visible_area(wo, m, S);
    float middle = grid_node(n / 2, 0, n, nodes.lambda).x;
    nodes.farthest = nodes.lambda * nodes.lambda + middle * middle + 2.0 * log(float(n));
    return nodes;
}

float node_uniform(const SlopeNodes nodes, const int j) {
    return (float(j) + (nodes.placement == LEADR_NODES_CENTRED ? 0.5 : 0.0)) / float(nodes.n);
}

// Returns the standard normal coordinate of a row: along the viewer's azimuth for visible normals, else along the first axis.
float node_row(const SlopeNodes nodes, const int j) {
    if (nodes.placement < LEADR_NODES_NORMALS) return grid_node(j, 0, nodes.n, nodes.lambda).x;
    return visible_slope_quantile(node_uniform(nodes, j), nodes.nu);
}

SlopeNode slope_node(const SlopeNodes nodes, const vec3 wo, const float row, const int k) {
    if (nodes.placement < LEADR_NODES_NORMALS) {
        vec2 p = vec2(row, grid_node(0, k, nodes.n, nodes.lambda).y);
        vec2 slope = slope_at(p, nodes.m, nodes.cholesky);
        float square = dot(p, p), spacing = grid_spacing(nodes.n, nodes.lambda);
        bool kept = nodes.placement != LEADR_NODES_PRUNED || square <= nodes.farthest * 1.000001;
        return SlopeNode(slope, kept ? exp(-0.5 * square) * facet_area(wo, slope) : 0.0, spacing * spacing);
    }
    vec2 p = vec2(row, normal_quantile(node_uniform(nodes, k)));
    vec2 e = nodes.along;
    vec2 slope = slope_at(vec2(e.x * p.x - e.y * p.y, e.y * p.x + e.x * p.y), nodes.m, nodes.cholesky);
    float density = exp(-0.5 * dot(p, p)) * (0.5 / LEADR_PI) * facet_area(wo, slope) / max(nodes.area, 1e-12);
    return SlopeNode(slope, 1.0, 1.0 / max(float(nodes.n * nodes.n) * density, 1e-12));
}

// Returns the artificial micronormal, whose weight is 1e-5 of the sum of the grid's weights times its own visible area. It has the weight 0
// with other placements, and where it is no slope.
SlopeNode artificial_node(const SlopeNodes nodes, const vec3 wo) {
    float spacing = grid_spacing(nodes.n, nodes.lambda);
    SlopeNode node = SlopeNode(vec2(0.0), 0.0, spacing * spacing);
    if (nodes.placement == LEADR_NODES_MICRONORMAL) {
        vec3 n = artificial_micronormal(wo, normal_of_slope(nodes.m));
        node.slope = -n.xy / max(n.z, 1e-3);
        float of_axis = 0.0;
        for (int j = 0; j < nodes.n; ++j) {
            float p = node_row(nodes, j);
            of_axis += exp(-0.5 * p * p);
        }
        node.weight = n.z > 1e-3 ? 1e-5 * of_axis * of_axis * facet_area(wo, node.slope) : 0.0;
    }
    return node;
}

void add_normal(inout NormalMoments sum, inout float norm, const SlopeNode node) {
    vec3 wn = normal_of_slope(node.slope);
    sum.mean += node.weight * wn;
    sum.diag += node.weight * wn * wn;
    sum.off += node.weight * wn.yzx * wn.zxy;
    norm += node.weight;
}

// Returns the moments of the visible normals, like visible_normal_moments on the even grid.
NormalMoments node_normal_moments(const int placement, const vec3 wo, const vec2 m, const vec3 S, const int n) {
    NormalMoments sum = NormalMoments(vec3(0.0), vec3(0.0), vec3(0.0));
    float norm = 0.0;
    SlopeNodes nodes = slope_nodes(placement, wo, m, S, n);
    for (int j = 0; j < n; ++j) {
        float row = node_row(nodes, j);
        for (int k = 0; k < n; ++k) {
            add_normal(sum, norm, slope_node(nodes, wo, row, k));
        }
    }
    if (placement == LEADR_NODES_MICRONORMAL) {
        add_normal(sum, norm, artificial_node(nodes, wo));
    }
    float scale = 1.0 / max(norm, 1e-12);
    return NormalMoments(sum.mean * scale, sum.diag * scale, sum.off * scale);
}

// Returns the radiance under one light, like leadr_diffuse_light on the even grid.
float node_diffuse_light(const int placement, const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const bool shadowing, const int n) {
    float sum = 0.0, norm = 0.0;
    SlopeNodes nodes = slope_nodes(placement, wo, m, S, n);
    for (int j = 0; j < n; ++j) {
        float row = node_row(nodes, j);
        for (int k = 0; k < n; ++k) {
            SlopeNode node = slope_node(nodes, wo, row, k);
            sum += node.weight * max(dot(wi, normal_of_slope(node.slope)), 0.0);
            norm += node.weight;
        }
    }
    if (placement == LEADR_NODES_MICRONORMAL) {
        SlopeNode last = artificial_node(nodes, wo);
        sum += last.weight * max(dot(wi, normal_of_slope(last.slope)), 0.0);
        norm += last.weight;
    }
    return shadowing_given_masking(wo, wi, m, S, shadowing) * sum / max(norm, 1e-12) / LEADR_PI;
}

#endif
