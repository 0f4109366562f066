#version 460
#include "leadr/visible_specular.glsl"
#include "leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 9;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    int n = int(next() + 0.5);
    at = gl_GlobalInvocationID.x * 20;
    LineRule rule = line_rule(n);
    VisibleLine line = visible_line(wo, m, S, 256.0, rule);
    put(line.mean);
    put(line.lod);
    // Squares: the sign of an axis is arbitrary.
    put(line.major * line.major);
    put(line.minor * line.minor);
    put(line.bend);
    float weights = 0.0;
    vec3 mirror = vec3(0.0), fresnel = vec3(0.0);
    float lod = 0.0;
    for (int i = 0; i < rule.n; ++i) {
        VisibleProbe p = visible_probe(line, wo, i, rule);
        weights += p.weight;
        mirror += p.weight * p.wi;
        fresnel += p.weight * fresnel_schlick(vec3(0.04, 0.5, 1.0), p.cosine);
        lod += p.weight * p.lod;
    }
    put(weights);
    put(mirror);
    put(fresnel);
    VisibleProbe middle = visible_probe_at(line, wo, 0.0, 1.0);
    put(middle.slope);
    put(middle.facet);
    put(lod);
}
