#ifndef LEADR_VISIBLE_SPECULAR_GLSL
#define LEADR_VISIBLE_SPECULAR_GLSL

#include "../facets/fresnel.glsl"
#include "../slopes/grid.glsl"
#include "kernel.glsl"
#include "slopes.glsl"

// Specular reflection of an environment by a few probes among the visible slopes. The lobe is taken apart into smaller, round
// Gaussians, one per probe: nodes on rings in the plane of two standard normals carry a part of its covariance, and each
// lookup is a kernel that has the rest (kernel.glsl says what cube that needs). Weights sum to one, so there is no division,
// and a constant environment returns its own value. src/reflectance/visible/specular.rs derives it. Once per pixel
//     VisibleProbes probes = visible_probes(wo, m, S, probe_kernel(n));
// and for i in 0..n-1, n = 5, 9 or 16
//     VisibleProbe p = visible_probe(probes, wo, probe_node(n, i, probes.wide));
//     vec3 f = p.weight * fresnel_schlick(f0, p.cosine);
//     reflected += f * textureLod(environment, from_frame(frame, p.wi), kernel_lod(p.variance, size)).rgb;
//     fresnel += f;                                             // the visible facets' mean
// Shadows: shadowed_specular.glsl.

// Azimuths of the nodes of 5, 9 and 16 probes, as unit vectors.
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

// Their rings: radius in standard deviations of the nodes, weight, variance of the kernel relative to others of the rule. First
// for narrow lobes, then in the limit of wide ones.
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
    vec3(0.0000, 0.225200000, 0.3706),
    vec3(2.2226, 0.193700000, 0.2636),
    vec3(0.9754, 0.113991140, 0.3249),
    vec3(2.3047, 0.109671097, 0.4442),
    vec3(0.0000, 0.128436147, 0.4576),
    vec3(1.0036, 0.042258732, 0.2562),
    vec3(2.2370, 0.068667940, 0.1729)
);

// Variance of round slopes, summed over both axes, at which a lobe is half wide.
const float LEADR_WIDE_HALF = 1.4;

// How wide a lobe is, 0 to 1. S: covariance of the slopes. Long lobes are as wide as they are across.
float wide_lobe(vec3 S) {
    float x = (4.0 / LEADR_WIDE_HALF) * max(S.x * S.y - S.z * S.z, 0.0) / max(S.x + S.y, 1e-15);
    return x * x / (1.0 + x * x);
}

struct ProbeNode {
    vec2 place;   // in units of `radius` standard deviations
    float radius; // equal for all nodes of a ring, like weight and cover
    float weight;
    float cover;  // variance of its kernel relative to others of the rule
};

// Node i of the rule of n probes, or of the next larger rule that exists, for a lobe that is `wide`. Where the compiler
// knows i, places are constants, and the rest is computed once per ring.
ProbeNode probe_node(int n, int i, float wide) {
    int first = n <= 5 ? 0 : n <= 9 ? 5 : 14;
    int ring = n <= 5 ? (i < 1 ? 0 : 1) : n <= 9 ? (i < 3 ? 2 : 3) : (i < 1 ? 4 : i < 7 ? 5 : 6);
    vec3 now = LEADR_NARROW_RINGS[ring] + wide * (LEADR_WIDE_RINGS[ring] - LEADR_NARROW_RINGS[ring]);
    return ProbeNode(LEADR_PROBE_AZIMUTHS[first + i], now.x, now.y, now.z);
}

// The kernels' share of the variance of a round lobe, if narrow and in the limit of wide ones, their share of a long one's along
// it, and the factor that gives the nodes of wide lobes unit variance, for the rule of n probes.
vec4 probe_kernel(int n) {
    return n <= 5 ? vec4(0.6, 0.32, 0.073, 0.7229) : n <= 9 ? vec4(0.5, 0.398, 0.024, 0.7235) : vec4(0.4, 0.237, 0.01, 0.7729);
}

// Quantities that the probes of a pixel share.
struct VisibleProbes {
    vec2 m;        // mean slope of all facets
    vec3 cholesky; // of their covariance
    vec2 middle;   // slope of a node at the origin
    vec3 spread;   // square root of the nodes' covariance
    vec2 bend;     // additional slope per u^2
    vec2 azimuth;  // u = azimuth . d, the slope along the view azimuth
    vec3 along;    // t = along.x + u + along.y u^2; half the inverse variance of the visible u
    vec3 whole;    // the square root that places the nodes over the whole lobe, for their Fresnel terms
    vec2 mean;     // `middle` for these places
    float shift;   // `along.x` for these places
    vec2 facet;    // projected area of the mesosurface, and how much of it is lost per unit of t
    float area;    // visible area A(wo)
    float kernel;  // variance of a lookup per a exp((t^2 - y^2)/2) / |N|^4
    float wide;    // how wide the lobe is
};

// The symmetric square root of a covariance (xx, yy, xy). Unlike a Cholesky factor, that of a thin one does not turn abruptly as
// it passes an axis.
vec3 root_of(vec3 S) {
    float det = sqrt(max(S.x * S.y - S.z * S.z, 0.0));
    float per = inversesqrt(max(S.x + S.y + 2.0 * det, 1e-18));
    return vec3(max(S.xy, 0.0) + det, S.z) * per;
}

VisibleProbes visible_probes(vec3 wo, vec2 m, vec3 S, vec4 kernel) {
    VisibleSlopes v = visible_slopes(wo, m, S);
    // Metric of reflected directions at the mean: |dwi|^2 = 4/|N|^2 ((p.ds)^2 + facet^2/|N|^2 (|ds|^2 - (s.ds)^2/|N|^2)).
    vec2 s = v.mean;
    float per = 1.0 / (1.0 + dot(s, s));
    vec2 p = wo.xy + s * (v.facet * per);
    float q = v.facet * v.facet * per;
    vec3 metric = 4.0 * per * vec3(p * p + q * (1.0 - s * s * per), p.x * p.y - q * s.x * s.y * per);
    float jacobian = 4.0 * v.facet * per * per;
    vec3 inverse_metric = vec3(metric.yx, -metric.z) / max(jacobian * jacobian, 1e-20);
    // The lobe's variances along its axes: their sum, their difference, the smaller one.
    const float least = 1e-15;
    float sum = max(v.cov.x * metric.x + v.cov.y * metric.y + 2.0 * v.cov.z * metric.z, 0.0);
    float per_sum = 1.0 / max(sum, least);
    float det = max(v.cov.x * v.cov.y - v.cov.z * v.cov.z, 0.0) * jacobian * jacobian;
    float round_lobe = min(4.0 * (det * per_sum) * per_sum, 1.0);
    float difference = sum * sqrt(1.0 - round_lobe);
    float minor = det / max(0.5 * (sum + difference), least);
    float round4 = round_lobe * round_lobe * round_lobe * round_lobe;
    float wide = wide_lobe(v.S);
    // 2 det/sum is the minor variance of round lobes, without its kink there.
    float share = kernel.x + wide * (kernel.y - kernel.x);
    float most = (minor - share * 0.5 * sum * round_lobe) * (round4 * round4);
    float elongated = kernel.z * sum * (1.0 - round_lobe);
    float variance = minor - most + elongated;
    // What nodes keep across the lobe: its variance less the kernel's, rounded off at 0.
    float rest = most - elongated;
    float soft = 0.1 * elongated;
    float root = sqrt(rest * rest + soft * soft);
    float of_lobe = 1.0 - 0.5 * (root - rest) / max(difference, max(1e-3 * sum, least));
    vec3 spread = of_lobe * v.cov + (0.5 * (rest + root) + 1e-3 * sum * (1.0 - round_lobe) - of_lobe * minor) * inverse_metric;

    float skew = v.third / (6.0 * v.variance * v.variance);
    VisibleProbes probes;
    probes.azimuth = wo.xy * (1.0 / max(v.b, 1e-18));
    vec2 a = probes.azimuth;
    // Rounding of a vanishing covariance must not look like a large one.
    float mean_square = clamp(a.x * (spread.x * a.x + 2.0 * spread.z * a.y) + spread.y * a.y * a.y, -1.0, 1.0);
    probes.bend = skew * v.axis;
    probes.m = v.m;
    probes.cholesky = slope_cholesky(v.S);
    probes.middle = v.mean - probes.bend * mean_square;
    probes.spread = root_of(spread);
    probes.whole = root_of(v.cov) * (1.0 + wide * (kernel.w - 1.0));
    probes.mean = v.mean - probes.bend * v.variance;
    probes.shift = -v.shift - skew * v.variance;
    probes.along = vec3(-v.shift - skew * mean_square, skew, 0.5 / v.variance);
    probes.facet = vec2(v.a, v.b);
    probes.area = v.area;
    probes.kernel = variance * v.area / (v.facet * sqrt(v.variance) * per * per);
    probes.wide = wide;
    return probes;
}

struct VisibleProbe {
    vec2 slope;
    vec3 wi;        // reflected direction, unit, tangent frame
    float cosine;   // wo . wn for the Fresnel term, 0..1
    float weight;
    float variance; // of the lookup, per axis, in radians squared, below 2
};

VisibleProbe visible_probe(VisibleProbes probes, vec3 wo, ProbeNode node) {
    vec2 place = node.radius * node.place;
    vec2 d = probes.spread.xz * place.x + probes.spread.zy * place.y;
    float u = clamp(dot(d, probes.azimuth), -6.0, 6.0);
    float u2 = u * u;
    float t = probes.along.x + u + probes.along.y * u2;
    VisibleProbe p;
    p.slope = probes.middle + d + probes.bend * u2;
    float z2 = 1.0 / (1.0 + dot(p.slope, p.slope));
    p.wi = (2.0 * max(probes.facet.x - t * probes.facet.y, 0.0) * z2) * vec3(-p.slope, 1.0) - wo;
    // The Fresnel term is convex, and a kernel does not filter it.
    vec2 whole = probes.whole.xz * place.x + probes.whole.zy * place.y;
    float v = clamp(dot(whole, probes.azimuth), -6.0, 6.0);
    vec2 slope = probes.mean + whole + probes.bend * (v * v);
    float facet = max(probes.facet.x - (probes.shift + v + probes.along.y * v * v) * probes.facet.y, 0.0);
    p.cosine = facet * inversesqrt(1.0 + dot(slope, slope));
    p.weight = node.weight;
    float stretch = exp(min(0.5 * t * t - probes.along.z * u2, 40.0)) * z2 * z2;
    float variance = min(probes.kernel * node.cover * stretch, 1e6);
    p.variance = variance / (1.0 + 0.5 * variance);
    return p;
}

#endif
