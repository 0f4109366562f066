#ifndef LEADR_VISIBLE_SPECULAR_GLSL
#define LEADR_VISIBLE_SPECULAR_GLSL

#include "../facets/fresnel.glsl"
#include "../slopes/grid.glsl"
#include "slopes.glsl"

// Specular reflection of an environment by a few probes among the visible slopes. The nodes lie on rings in the plane of
// two standard normals; the covariance of the surface's slopes and, along the view azimuth, the moments of the visible
// slopes map them to the surface. Each probe covers the solid angle that its node represents. Weights sum to one, so there
// is no division, and a constant environment returns its own value. src/reflectance/visible/specular.rs derives it. Once
// per pixel
//     VisibleProbes probes = visible_probes(wo, m, S);
// and for i in 0..n-1, n = 5, 9 or 16
//     VisibleProbe p = visible_probe(probes, wo, probe_node(n, i, probes.wide));
//     vec3 f = p.weight * fresnel_schlick(f0, p.cosine);
//     reflected += f * textureLod(environment, from_frame(frame, p.wi), solid_angle_lod(p.solid_angle, size)).rgb;
//     fresnel += f;                                             // the visible facets' mean
// Shadows: shadowed_specular.glsl.

// Place in standard deviations, weight, measure of the area that the probe covers.
const vec4 LEADR_PROBE_NODES[30] = vec4[](
    vec4(0.0000000, 0.0000000, 0.331413372, 0.1653),
    vec4(1.5346768, 0.6311698, 0.167146657, 0.3691),
    vec4(-0.6311698, 1.5346768, 0.167146657, 0.3691),
    vec4(-1.5346768, -0.6311698, 0.167146657, 0.3691),
    vec4(0.6311698, -1.5346768, 0.167146657, 0.3691),
    vec4(0.7288765, -0.2973599, 0.141900000, 0.0624),
    vec4(0.2973599, 0.7288765, 0.141900000, 0.0624),
    vec4(-0.7288765, 0.2973599, 0.141900000, 0.0624),
    vec4(-0.2973599, -0.7288765, 0.141900000, 0.0624),
    vec4(1.1148321, -1.5320044, 0.086480000, 0.2531),
    vec4(1.8015248, 0.5868529, 0.086480000, 0.2531),
    vec4(-0.0014285, 1.8946995, 0.086480000, 0.2531),
    vec4(-1.8024077, 0.5841357, 0.086480000, 0.2531),
    vec4(-1.1125207, -1.5336837, 0.086480000, 0.2531),
    vec4(0.0000000, 0.0000000, 0.140932952, 0.0481),
    vec4(0.9914263, 0.1458707, 0.081605920, 0.0489),
    vec4(0.3693854, 0.9315357, 0.081605920, 0.0489),
    vec4(-0.6220409, 0.7856650, 0.081605920, 0.0489),
    vec4(-0.9914263, -0.1458707, 0.081605920, 0.0489),
    vec4(-0.3693854, -0.9315357, 0.081605920, 0.0489),
    vec4(0.6220409, -0.7856650, 0.081605920, 0.0489),
    vec4(1.7005644, 0.9899111, 0.041047948, 0.1309),
    vec4(0.6664053, 1.8514176, 0.041047948, 0.1309),
    vec4(-0.6795722, 1.8466253, 0.041047948, 0.1309),
    vec4(-1.7075704, 0.9777764, 0.041047948, 0.1309),
    vec4(-1.9365774, -0.3485849, 0.041047948, 0.1309),
    vec4(-1.2594383, -1.5118394, 0.041047948, 0.1309),
    vec4(0.0070060, -1.9676875, 0.041047948, 0.1309),
    vec4(1.2701720, -1.5028327, 0.041047948, 0.1309),
    vec4(1.9390105, -0.3347858, 0.041047948, 0.1309)
);

// How the three rings of 16 nodes change in the limit of wide lobes: factor of the radius, weight, measure.
const vec3 LEADR_WIDE_RINGS[3] = vec3[](
    vec3(1.0000, 0.0867223, 0.0428),
    vec3(0.8826, 0.0717759, 0.0566),
    vec3(0.9257, 0.0536247, 0.2443)
);

// Slope variance, summed over both axes, up to which a lobe counts as narrow, and the excess that makes it half wide.
const float LEADR_WIDE_FROM = 0.25;
const float LEADR_WIDE_HALF = 0.25;

// How wide a lobe is, 0 to 1. S: covariance of the slopes.
float wide_lobe(vec3 S) {
    float x = max(S.x + S.y - LEADR_WIDE_FROM, 0.0) * (1.0 / LEADR_WIDE_HALF);
    return x * x / (1.0 + x * x);
}

struct ProbeNode {
    vec2 place;   // in units of `radius` standard deviations
    float radius; // equal for all nodes of a ring, like weight and cover
    float weight;
    float cover;  // measure of the area that its probe covers
};

// Node i of the rule of n probes, or of the next larger rule that exists, for a lobe that is `wide`. Where the compiler
// knows i, places are constants, and the rest is computed once per ring.
ProbeNode probe_node(int n, int i, float wide) {
    vec4 node = LEADR_PROBE_NODES[i + (n <= 5 ? 0 : n <= 9 ? 5 : 14)];
    if (n <= 9) return ProbeNode(node.xy, 1.0, node.z, node.w);
    vec3 ring = LEADR_WIDE_RINGS[i < 1 ? 0 : i < 7 ? 1 : 2];
    vec3 now = vec3(1.0, node.zw) + wide * (ring - vec3(1.0, node.zw));
    return ProbeNode(node.xy, now.x, now.y, now.z);
}

const float LEADR_NODE_VARIANCE = 0.95;
// Share of the variance along a very elongated footprint that is added to the solid angle of its probes.
const float LEADR_LONG_FOOTPRINT = 0.02;

// Quantities that the probes of a pixel share.
struct VisibleProbes {
    vec2 m;        // mean slope of all facets
    vec3 cholesky; // of their covariance
    vec2 axis;     // change of slope per standard deviation along the view azimuth
    vec2 azimuth;  // x = azimuth . C p
    vec3 along;    // mean, deviation and skewness of the visible slopes along it
    vec2 facet;    // projected area of the mesosurface, and how much of it is lost per unit of t
    float area;    // visible area A(wo)
    float cover;   // solid angle per a exp((t^2 - x^2)/2) / |N|^4
    float least;   // smallest solid angle of a probe, added to every one
    float wide;    // how wide the lobe is
};

VisibleProbes visible_probes(vec3 wo, vec2 m, vec3 S) {
    VisibleSlopes v = visible_slopes(wo, m, S);
    VisibleProbes probes;
    probes.m = v.m;
    probes.cholesky = slope_cholesky(v.S);
    float per_b = 1.0 / max(v.b, 1e-18);
    probes.axis = v.axis;
    probes.azimuth = wo.xy * per_b;
    probes.along = vec3(-v.shift, sqrt(v.variance), v.third / (6.0 * v.variance));
    probes.facet = vec2(v.a, v.b);
    probes.area = v.area;
    probes.cover = 25.1327412 * v.area * probes.cholesky.x * probes.cholesky.z;
    // Metric of reflected directions at the mean: |dwi|^2 = 4/|N|^2 ((p.ds)^2 + facet^2/|N|^2 (|ds|^2 - (s.ds)^2/|N|^2)).
    vec2 s = v.mean;
    float per = 1.0 / (1.0 + dot(s, s));
    vec2 p = wo.xy + s * (v.facet * per);
    float q = v.facet * v.facet * per;
    vec3 metric = 4.0 * per * vec3(p * p + q * (1.0 - s * s * per), p.x * p.y - q * s.x * s.y * per);
    // With the footprint's variances l1 and l2 along its axes: (l1 - l2)^2 / (l1 + l2).
    float trace = v.cov.x * metric.x + v.cov.y * metric.y + 2.0 * v.cov.z * metric.z;
    float jacobian = 4.0 * v.facet * per * per;
    float det = max(v.cov.x * v.cov.y - v.cov.z * v.cov.z, 0.0) * jacobian * jacobian;
    probes.wide = wide_lobe(v.S);
    probes.least = LEADR_LONG_FOOTPRINT * max(trace - 4.0 * det / max(trace, 1e-20), 0.0);
    return probes;
}

struct VisibleProbe {
    vec2 slope;
    vec3 wi;           // reflected direction, unit, tangent frame
    float cosine;      // wo . wn, 0..1
    float weight;
    float solid_angle; // footprint of the lookup, in steradians
};

VisibleProbe visible_probe(VisibleProbes probes, vec3 wo, ProbeNode node) {
    vec3 c = node.radius * probes.cholesky;
    vec2 d = vec2(c.x * node.place.x, c.y * node.place.x + c.z * node.place.y);
    float x = dot(d, probes.azimuth);
    float t = probes.along.x + x * probes.along.y + (x * x - LEADR_NODE_VARIANCE) * probes.along.z;
    VisibleProbe p;
    p.slope = probes.m + d + probes.axis * (t - x);
    float z2 = 1.0 / (1.0 + dot(p.slope, p.slope));
    float z = sqrt(z2);
    p.cosine = max(probes.facet.x - t * probes.facet.y, 0.0) * z;
    p.wi = (2.0 * p.cosine * z) * vec3(-p.slope, 1.0) - wo;
    p.weight = node.weight;
    p.solid_angle = probes.cover * (node.cover * exp(min(0.5 * (t * t - x * x), 40.0)) * z2 * z2) + probes.least;
    return p;
}

// Level of detail whose texels have this solid angle on average. size: texels per edge of the cube map.
float solid_angle_lod(float solid_angle, float size) {
    return 0.5 * log2(max(solid_angle, 1e-12) * 0.477464829) + log2(size);
}

#endif
