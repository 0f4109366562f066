#ifndef LEADR_VISIBLE_SPECULAR_GLSL
#define LEADR_VISIBLE_SPECULAR_GLSL

#include "../masking/correlated.glsl"
#include "../slopes/grid.glsl"
#include "fresnel.glsl"
#include "kernel.glsl"
#include "lit_slopes.glsl"
#include "slopes.glsl"

// Computes the specular reflection of an environment by a few probes among the visible slopes. The lobe is split into smaller, round
// Gaussians, one per probe. Nodes on rings in the plane of two standard normals carry a part of the lobe's covariance, and each lookup is a
// kernel with the remaining covariance (kernel.glsl describes the cube). Weights sum to one, so there is no division, and a constant
// environment returns its own value. crates/leadr-reflectance/src/visible/specular.rs has the derivation. Once per pixel
//     VisibleProbes probes = visible_probes(LEADR_SHADOWING_NONE, wo, m, S, probe_kernel(n));
// and for i in 0..n-1, n = 5, 9 or 16 (few_node for n = 3)
//     VisibleProbe p = visible_probe(probes, wo, probe_node(n, i, probes.wide));
//     vec3 f = p.weight * fresnel_schlick(f0, p.cosine);
//     reflected += f * textureLod(environment, from_frame(frame, p.wi), kernel_lod(p.variance, size)).rgb;
// The sum is the mean over the visible facets. With shadows (shadowed_specular.glsl), the probes represent the lit part of the lobe.

// The azimuths of the nodes for 5, 9 and 16 probes, as unit vectors.
const vec2 LEADR_PROBE_AZIMUTHS[30] = vec2[](
    vec2(0.0000000, 0.0000000),
    vec2(0.9249091, 0.3801884),
    vec2(-0.3801884, 0.9249091),
    vec2(-0.9249091, -0.3801884),
    vec2(0.3801884, -0.9249091),
    vec2(1.0000000, 0.0000000),
    vec2(-0.5000000, 0.8660254),
    vec2(-0.5000000, -0.8660254),
    vec2(0.9365346, -0.3505753),
    vec2(0.7718744, 0.6357751),
    vec2(-0.1646602, 0.9863504),
    vec2(-0.9365346, 0.3505753),
    vec2(-0.7718744, -0.6357751),
    vec2(0.1646602, -0.9863504),
    vec2(0.0000000, 0.0000000),
    vec2(0.9365346, -0.3505753),
    vec2(0.7718744, 0.6357751),
    vec2(-0.1646602, 0.9863504),
    vec2(-0.9365346, 0.3505753),
    vec2(-0.7718744, -0.6357751),
    vec2(0.1646602, -0.9863504),
    vec2(-0.9974516, -0.0713467),
    vec2(-0.7182315, -0.6958042),
    vec2(-0.1029429, -0.9946873),
    vec2(0.5605138, -0.8281451),
    vec2(0.9616999, -0.2741046),
    vec2(0.9128959, 0.4081925),
    vec2(0.4369378, 0.8994917),
    vec2(-0.2434684, 0.9699088),
    vec2(-0.8099530, 0.5864948)
);

// The rings of the nodes. Each has a radius in standard deviations of the nodes, a weight, and the relative variance of its kernel. The
// first array is for narrow lobes, and the second is the limit for wide lobes.
const vec3 LEADR_NARROW_RINGS[7] = vec3[](
    vec3(0.0000, 0.229228000, 0.7055),
    vec3(1.6108, 0.192693000, 1.0876),
    vec3(0.5434, 0.110301110, 0.7833),
    vec3(1.6861, 0.111516112, 1.1072),
    vec3(0.0000, 0.101126798, 0.9533),
    vec3(0.9437, 0.082907834, 0.8668),
    vec3(1.9694, 0.044602911, 1.1769)
);
const vec3 LEADR_WIDE_RINGS[7] = vec3[](
    vec3(0.0000, 0.396920000, 1.7688),
    vec3(1.8211, 0.150770000, 0.9803),
    vec3(0.7234, 0.169077662, 1.3253),
    vec3(1.8762, 0.082127836, 1.0869),
    vec3(0.0000, 0.129550000, 1.2382),
    vec3(1.0018, 0.081103000, 1.1103),
    vec3(1.9845, 0.042648000, 1.2183)
);

// The variance of isotropic slopes, summed over both axes, for which wide_lobe returns one half.
const float LEADR_WIDE_HALF = 0.35;

// Returns the width of a lobe, 0 to 1. S is the covariance of the slopes. Elongated lobes use their minor axis.
float wide_lobe(const vec3 S) {
    float x = (4.0 / LEADR_WIDE_HALF) * max(S.x * S.y - S.z * S.z, 0.0) / max(S.x + S.y, 1e-15);
    return x * x / (1.0 + x * x);
}

struct ProbeNode {
    vec2 unit_offset; // in units of `radius` standard deviations
    float radius; // equal for all nodes of a ring, as are weight and cover
    float weight;
    float cover;  // variance of the node's kernel, relative to the other kernels of the rule
};

// Returns node i of the rule with n probes, or of the next larger rule, for a lobe of width `wide`. For a constant i, the position is a
// constant, and the other values are computed once per ring.
ProbeNode probe_node(const int n, const int i, const float wide) {
    int first = n <= 5 ? 0 : n <= 9 ? 5 : 14;
    int ring = n <= 5 ? (i < 1 ? 0 : 1) : n <= 9 ? (i < 3 ? 2 : 3) : (i < 1 ? 4 : i < 7 ? 5 : 6);
    vec3 now = LEADR_NARROW_RINGS[ring] + wide * (LEADR_WIDE_RINGS[ring] - LEADR_NARROW_RINGS[ring]);
    return ProbeNode(LEADR_PROBE_AZIMUTHS[first + i], now.x, now.y, now.z);
}

// The ring of the rule with three probes, for lobes of any width.
const vec3 LEADR_THREE_RING = vec3(1.41421356, 0.33333333, 1.0);

// Returns the kernels' fractions of a lobe's variance for the rule with n probes: for a narrow round lobe, for a round lobe in the limit of
// wide lobes, and along an elongated lobe.
vec3 probe_kernel(const int n) {
    return n <= 5 ? vec3(0.6, 0.413, 0.073) : n <= 9 ? vec3(0.5, 0.262, 0.024) : vec3(0.4, 0.167, 0.01);
}

// Returns the symmetric square root of a covariance (xx, yy, xy). Unlike a Cholesky factor, the root of a thin covariance changes smoothly
// when the covariance rotates past an axis.
vec3 root_of(const vec3 S) {
    float det = sqrt(max(S.x * S.y - S.z * S.z, 0.0));
    float per = inversesqrt(max(S.x + S.y + 2.0 * det, 1e-18));
    return vec3(max(S.xy, 0.0) + det, S.z) * per;
}

// The positions of a rule's nodes among the slopes: middle + root p + bend u^2 with u = azimuth . root p.
struct NodePositions {
    vec2 middle;  // slope of a node at the origin
    vec3 root;    // square root of the nodes' covariance
    vec2 bend;
    vec2 azimuth;
};

// Returns the slope of a node, and the u of this node.
vec3 node_slope(const NodePositions nodes, const vec2 p) {
    vec2 d = nodes.root.xz * p.x + nodes.root.zy * p.y;
    float u = clamp(dot(d, nodes.azimuth), -6.0, 6.0);
    return vec3(nodes.middle + d + nodes.bend * (u * u), u);
}

// Returns positions with covariance `spread` and the skewness of v about its mean. `along` returns the coefficient of u^2 and E[u^2].
NodePositions node_positions(const vec3 wo, const VisibleSlopes v, const vec3 spread, out vec2 along) {
    NodePositions nodes;
    vec2 a = wo.xy * (1.0 / max(v.b, 1e-18));
    along.x = v.third / (6.0 * v.variance * v.variance);
    // The clamp limits rounding errors if the covariance vanishes.
    along.y = clamp(a.x * (spread.x * a.x + 2.0 * spread.z * a.y) + spread.y * a.y * a.y, -1.0, 1.0);
    nodes.azimuth = a;
    nodes.bend = along.x * v.axis;
    nodes.middle = v.mean - nodes.bend * along.y;
    nodes.root = root_of(spread);
    return nodes;
}

// The lit_spread of wide lobes, and of views from straight above. For narrow lobes seen edge-on, it is twice as large.
const float LEADR_LIT_SPREAD = 0.6;

// The quantities that all probes of a pixel share.
struct VisibleProbes {
    vec2 m;        // mean slope of all facets
    vec3 cholesky; // Cholesky factor of the covariance of all facets
    float area;    // visible area A(wo) of all facets
    NodePositions nodes;
    vec3 along;    // coefficients of t = along.x + u + along.y u^2; half the inverse variance of the visible u
    vec2 facet;    // projected area of the mesosurface, and the decrease of this area per unit of t
    vec3 part;     // slope covariance of one kernel
    float kernel;  // lookup variance per unit of a exp((t^2 - y^2)/2) / |N|^4
    float wide;    // width of the lobe, 0 to 1
    NodePositions fresnel_nodes; // nodes over the whole lobe, lit or not, for the Fresnel terms
    float flat_area;  // projected area of a facet of slope 0 in this lobe
    vec2 projected;   // growth of kernels with the projected area of their facet, 0 to 1, and the inverse of the area at the mean
    // The fraction of a probe's variance that remains in each of the two directions into which the probe is split.
    float lit_spread;
    VisibleCosines cosines; // of all visible facets
    float grazing; // mean of Schlick's weight over all visible facets
    LitSlopes lit; // slopes that probes represent instead of all visible ones; the mean weight includes the ratio of the visible areas
};

// Returns the probes for these slopes or, with shadowing, for their lit part.
VisibleProbes visible_probes_of(const int shadowing, vec3 wo, VisibleSlopes all, vec3 kernel) {
    VisibleSlopes v = all;
    VisibleProbes probes;
    probes.lit = LitSlopes(all.m, all.S, vec2(0.0), vec3(0.0), 0.0);
    if (shadowing != LEADR_SHADOWING_NONE) {
        probes.lit = lit_slopes(wo, all);
        v = visible_slopes(wo, probes.lit.m, probes.lit.S);
        probes.lit.mean += log(max(v.area, 1e-30) / max(all.area, 1e-30));
    }
    // The metric of reflected directions at the mean is |dwi|^2 = 4/|N|^2 ((p.ds)^2 + facet^2/|N|^2 (|ds|^2 - (s.ds)^2/|N|^2)).
    vec2 s = v.mean;
    float per = 1.0 / (1.0 + dot(s, s));
    vec2 p = wo.xy + s * (v.facet * per);
    float q = v.facet * v.facet * per;
    vec3 metric = 4.0 * per * vec3(p * p + q * (1.0 - s * s * per), p.x * p.y - q * s.x * s.y * per);
    float jacobian = 4.0 * v.facet * per * per;
    vec3 inverse_metric = vec3(metric.yx, -metric.z) / max(jacobian * jacobian, 1e-20);
    // The next values are the sum of the lobe's variances along its axes, their difference, and the smaller variance.
    const float least = 1e-15;
    float sum = max(v.cov.x * metric.x + v.cov.y * metric.y + 2.0 * v.cov.z * metric.z, 0.0);
    float per_sum = 1.0 / max(sum, least);
    float det = max(v.cov.x * v.cov.y - v.cov.z * v.cov.z, 0.0) * jacobian * jacobian;
    float round_lobe = min(4.0 * (det * per_sum) * per_sum, 1.0);
    float difference = sum * sqrt(1.0 - round_lobe);
    float minor = det / max(0.5 * (sum + difference), least);
    float round4 = round_lobe * round_lobe * round_lobe * round_lobe;
    float wide = wide_lobe(all.S);
    float even = round4 * round4 + wide * (1.0 - round4 * round4);
    float share = kernel.x + wide * (kernel.y - kernel.x);
    // 2 det/sum replaces the minor variance of round lobes, because the minor variance has a kink where a lobe is round.
    float most = (minor - share * 0.5 * sum * round_lobe) * even;
    float elongated = kernel.z * sum * (1.0 - round_lobe);
    float variance = minor - most + elongated;
    // The variance of the nodes across the lobe is the variance of the lobe minus the variance of the kernel, smoothly clamped at 0.
    float rest = most - elongated;
    float soft = 0.1 * elongated;
    float root = sqrt(rest * rest + soft * soft);
    float of_lobe = 1.0 - 0.5 * (root - rest) / max(difference, max(1e-3 * sum, least));
    vec3 spread = of_lobe * v.cov + (0.5 * (rest + root) + 1e-3 * sum * (1.0 - round_lobe) - of_lobe * minor) * inverse_metric;

    vec2 along, unused;
    probes.m = all.m;
    probes.cholesky = slope_cholesky(all.S);
    probes.area = all.area;
    probes.nodes = node_positions(wo, v, spread, along);
    probes.along = vec3(-v.shift - along.x * along.y, along.x, 0.5 / v.variance);
    probes.facet = vec2(v.a, v.b);
    probes.part = (1.0 - wide) * (v.cov - spread);
    probes.kernel = variance * v.area / (v.facet * sqrt(v.variance) * per * per);
    probes.wide = wide;
    probes.fresnel_nodes = node_positions(wo, all, all.cov, unused);
    probes.flat_area = all.a + dot(wo.xy, all.m);
    float sine2 = max(1.0 - all.a * all.a / (1.0 + dot(all.m, all.m)), 0.0);
    probes.lit_spread = LEADR_LIT_SPREAD * (1.0 + (1.0 - wide) * sine2);
    probes.projected = vec2(0.0);
    probes.cosines = visible_cosines(all);
    probes.grazing = mean_schlick_weight(probes.cosines);
    return probes;
}

// Returns the probes for all facets visible from wo.
VisibleProbes visible_probes(const int shadowing, const vec3 wo, const vec2 m, const vec3 S, const vec3 kernel) {
    return visible_probes_of(shadowing, wo, visible_slopes(wo, m, S), kernel);
}

// Returns node i of the rule with n = 3 or 5 probes. n and i can be variables. Three nodes are symmetric about the line orthogonal to the
// viewer's azimuth. Fresnel terms and shadows change most along the azimuth, where skewed nodes would be wrong.
// A part of the azimuth itself keeps the direction stable across long lobes.
ProbeNode few_node(const VisibleProbes probes, const vec3 wo, const int n, const int i) {
    vec2 axis = LEADR_PROBE_AZIMUTHS[1];
    vec2 turn = i == 1 ? vec2(1.0, 0.0) : i == 2 ? vec2(0.0, 1.0) : i == 3 ? vec2(-1.0, 0.0) : vec2(0.0, -1.0);
    vec3 narrow = LEADR_NARROW_RINGS[1], widest = LEADR_WIDE_RINGS[1];
    if (i == 0) {
        turn = vec2(0.0);
        narrow = LEADR_NARROW_RINGS[0];
        widest = LEADR_WIDE_RINGS[0];
    }
    if (n <= 3) {
        vec3 root = probes.nodes.root / max(probes.nodes.root.x + probes.nodes.root.y, 1e-18);
        vec2 view = vec2(dot(root.xz, wo.xy), dot(root.zy, wo.xy)) + 0.03 * wo.xy + vec2(1e-6, 0.0);
        axis = vec2(-view.y, view.x) * inversesqrt(dot(view, view));
        turn = i == 0 ? vec2(1.0, 0.0) : vec2(-0.5, i == 1 ? 0.8660254 : -0.8660254);
        narrow = widest = LEADR_THREE_RING;
    }
    vec3 now = narrow + probes.wide * (widest - narrow);
    return ProbeNode(turn.x * axis + turn.y * vec2(-axis.y, axis.x), now.x, now.y, now.z);
}

struct VisibleProbe {
    vec2 slope;
    vec3 mirror;    // the direction that the probe's facet reflects, unit length, in the tangent frame
    vec3 wi;        // mean reflected direction of the probe's part of the lobe, in the tangent frame; it need not be a unit vector
    float cosine;   // wo . wn for the Fresnel term of all visible facets, 0..1
    float weight;
    float variance; // variance of the lookup per axis, in radians squared, below 2
};

// Returns the mean direction reflected by Gaussian slopes of covariance c about `slope`, to second order. The direction is not normalised.
// f is the projected area of the facet at `slope`.
vec3 mean_mirror(const vec3 wo, const vec2 slope, const float f, const vec3 c) {
    vec2 o = vec2(dot(c.xz, wo.xy), dot(c.zy, wo.xy));
    vec2 s = vec2(dot(c.xz, slope), dot(c.zy, slope));
    float per = 1.0 / (1.0 + dot(slope, slope) + c.x + c.y);
    float up = f + 2.0 * per * (dot(wo.xy, s) + 2.0 * per * f * dot(slope, s));
    return 2.0 * per * vec3(o + 2.0 * per * f * s - up * slope, up) - wo;
}

VisibleProbe visible_probe(const VisibleProbes probes, const vec3 wo, const ProbeNode node) {
    vec2 offset = node.radius * node.unit_offset;
    vec3 at = node_slope(probes.nodes, offset);
    float u2 = at.z * at.z;
    float t = probes.along.x + at.z + probes.along.y * u2;
    float z2 = 1.0 / (1.0 + dot(at.xy, at.xy));
    VisibleProbe p;
    p.slope = at.xy;
    p.mirror = 2.0 * max(wo.z - dot(wo.xy, at.xy), 0.0) * z2 * vec3(-at.xy, 1.0) - wo;
    float facet = max(probes.facet.x - t * probes.facet.y, 0.0);
    p.wi = mean_mirror(wo, at.xy, facet, probes.part);
    // The Fresnel term has its own nodes, because it is convex and the kernel of a lookup does not filter it.
    vec2 fresnel_slope = node_slope(probes.fresnel_nodes, offset).xy;
    p.cosine = min(max(probes.flat_area - dot(wo.xy, fresnel_slope), 0.0) * inversesqrt(1.0 + dot(fresnel_slope, fresnel_slope)), 1.0);
    p.weight = node.weight;
    float stretch = exp(min(0.5 * t * t - probes.along.z * u2, 40.0)) * z2 * z2;
    float grown = 1.0 + probes.projected.x * (facet * probes.projected.y - 1.0);
    float variance = min(probes.kernel * node.cover * stretch * grown, 1e6);
    p.variance = variance / (1.0 + 0.5 * variance);
    return p;
}

#endif
