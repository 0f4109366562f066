#ifndef LEADR_VISIBLE_SPECULAR_GLSL
#define LEADR_VISIBLE_SPECULAR_GLSL

#include "fresnel.glsl"
#include "slope_grid.glsl"
#include "visible_slopes.glsl"

// Specular reflection of an environment by a line of probes. The visible slopes, carried onto the sphere of reflected
// directions, cover an ellipse. Its minor axis is left to the prefiltered environment, the major axis to probes along it,
// with weights that sum to one: no division, and a constant environment gives its own value.
//
// Once per pixel
//     VisibleLine line = visible_line(wo, m, S, size, LINE);
// and for i in 0..N-1
//     VisibleProbe p = visible_probe(line, wo, i, LINE);
//     vec3 f = fresnel_schlick(f0, p.cosine) * p.weight;
//     reflected += f * textureLod(environment, from_frame(frame, p.wi), p.lod).rgb;   // times shadowing, if any
//     fresnel += f;                                                                  // mean over the visible facets

// The rule of n probes, equally spaced, of unit variance; n = 3, 5, 7, 9, 16, or what is nearest.
struct LineRule {
    int n;
    float step;   // between probes, in standard deviations
    float decay;  // weight of probe i: norm exp(-decay (i - (n-1)/2)^2)
    float norm;
    float kernel; // least variance of the environment's kernel, over that of the major axis
    float bias;   // of the level of detail
};

LineRule line_rule(int n) {
    if (n <= 3) return LineRule(3, 1.59377176, 1.125, 0.606316018, 0.25, -0.45);
    if (n <= 5) return LineRule(5, 0.967347788, 0.405, 0.366333776, 0.15, -0.45);
    if (n <= 7) return LineRule(7, 0.710108375, 0.222222222, 0.270682149, 0.09, -0.45);
    if (n <= 9) return LineRule(9, 0.576461842, 0.15125, 0.222126564, 0.06, -0.45);
    return LineRule(16, 0.343818118, 0.0555555556, 0.133969879, 0.025, -0.45);
}

struct VisibleLine {
    vec2 mean;   // mean visible slope
    vec2 major;  // from it along the line, per unit of z
    vec2 bend;   // shift by the skewness, per unit of z^2 - 1
    vec2 minor;  // the other axis: one standard deviation of the visible slopes across the line
    float area;  // visible area A(wo)
    float lod;   // level of detail of a probe, less its own Jacobian
};

// Jacobian of slopes to reflected directions over four: |wn.wo| wn.z^3; facet = wo.z - wo.xy . slope, signed.
float reflection_jacobian(float facet, float squared_normal) {
    return abs(facet) / (squared_normal * squared_normal);
}

// size: texels per edge of the environment's cube map.
VisibleLine visible_line(vec3 wo, vec2 m, vec3 S, float size, LineRule rule) {
    VisibleSlopes v = visible_slopes(wo, m, S);
    // Metric of reflected directions at the mean: |dwi|^2 = 4/|N|^2 ((p.ds)^2 + facet^2/|N|^2 (|ds|^2 - (s.ds)^2/|N|^2)).
    vec2 s = v.mean;
    float per = 1.0 / (1.0 + dot(s, s));
    float facet = max(meso_area(wo, s), 1e-6);
    vec2 p = wo.xy + s * (facet * per);
    float q = facet * facet * per;
    vec3 metric = 4.0 * per * vec3(p * p + q * (1.0 - s * s * per), p.x * p.y - q * s.x * s.y * per);
    // Eigenvalues of cov metric: variances along the axes of the ellipse of reflected directions.
    vec3 c = v.cov;
    float half_trace = 0.5 * (c.x * metric.x + c.y * metric.y) + c.z * metric.z;
    float det = max(c.x * c.y - c.z * c.z, 0.0);
    float jacobian = 4.0 * facet * per * per;
    float difference = sqrt(max(half_trace * half_trace - det * jacobian * jacobian, 0.0));
    float wide = max(half_trace + difference, 1e-20), narrow = det * jacobian * jacobian / wide;
    // cov less the minor axis' part is of rank one, and that is the major axis; nothing turns or jumps where the ellipse
    // is a circle, since it then has length zero.
    float less = det / wide;
    vec3 rank = max(vec3(c.x - less * metric.y, c.y - less * metric.x, 0.0), vec3(1e-20, 1e-20, 0.0));
    float bound = sqrt(rank.x * rank.y);
    rank.z = clamp(c.z + less * metric.z, -bound, bound);
    vec2 major = rank.x > rank.y ? vec2(rank.x, rank.z) * inversesqrt(rank.x) : vec2(rank.z, rank.y) * inversesqrt(rank.y);
    float kept = min((1.0 - rule.kernel) * wide / max(wide - narrow, 1e-20), 1.0);
    VisibleLine line;
    line.mean = s;
    line.major = major * sqrt(max(kept, 0.0));
    float u = clamp(dot(line.major, wo.xy) / max(v.b, 1e-18), -1.0, 1.0) / v.variance;
    line.bend = v.axis * (v.third * u * u / 6.0);
    vec2 h = vec2(metric.x * major.x + metric.z * major.y, metric.z * major.x + metric.y * major.y);
    line.minor = vec2(-h.y, h.x) * sqrt(det / max(wide * dot(h, major), 1e-30));
    line.area = v.area;
    // A box-filtered level and bilinear lookup of texels h have variance h^2/4 (here: 2/1.447).
    float kernel = max(max(rule.kernel * wide, narrow), 1e-12);
    line.lod = 0.5 * log2(kernel / max(jacobian, 1e-12)) + log2(size) + 0.467 + rule.bias;
    return line;
}

struct VisibleProbe {
    vec2 slope;
    vec3 wi;      // reflected direction, unit, tangent frame
    float cosine; // wo . wn
    float facet;  // wo.z - wo.xy . slope: projected area of the facet
    float weight;
    float lod;    // of the environment; may be negative
};

// The probe at z standard deviations along the line.
VisibleProbe visible_probe_at(VisibleLine line, vec3 wo, float z, float weight) {
    VisibleProbe p;
    p.slope = line.mean + z * line.major + (z * z - 1.0) * line.bend;
    float squared = 1.0 + dot(p.slope, p.slope);
    vec3 wn = vec3(-p.slope, 1.0) * inversesqrt(squared);
    p.facet = meso_area(wo, p.slope);
    p.cosine = dot(wo, wn);
    p.wi = 2.0 * p.cosine * wn - wo;
    p.weight = weight;
    p.lod = line.lod + 0.5 * log2(max(4.0 * reflection_jacobian(p.facet, squared), 1e-12));
    return p;
}

VisibleProbe visible_probe(VisibleLine line, vec3 wo, int i, LineRule rule) {
    float j = float(i) - 0.5 * float(rule.n - 1);
    return visible_probe_at(line, wo, j * rule.step, rule.norm * exp(-rule.decay * j * j));
}

#endif
