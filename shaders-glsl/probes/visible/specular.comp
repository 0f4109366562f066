#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 9;
    vec3 wo = next3();
    vec2 m = next2();
    vec3 S = next3();
    int n = int(next() + 0.5);
    at = gl_GlobalInvocationID.x * 15;
    VisibleProbes probes = visible_probes(LEADR_SHADOWING_NONE, wo, m, S, probe_kernel(n));
    float unit = inversesqrt(max(S.x + S.y, 1e-8));
    float weights = 0.0, lod = 0.0, cosine = 0.0;
    vec3 mirror = vec3(0.0), fresnel = vec3(0.0);
    VisibleProbe p;
    for (int i = 0; i < n; ++i) {
        ProbeNode node = n <= 5 ? few_node(probes, wo, n, i) : probe_node(n, i, probes.wide);
        p = visible_probe(probes, wo, node);
        weights += p.weight;
        p.wi = normalize(p.wi);
        mirror += p.weight * p.wi;
        fresnel += p.weight * fresnel_schlick(vec3(0.04, 0.5, 1.0), p.cosine);
        lod += p.weight * kernel_lod(p.variance, 256.0);
        cosine += p.weight * p.cosine;
    }
    put(weights);
    put(mirror);
    put(fresnel);
    put(cosine);
    put(lod);
    // The last probe has these values.
    put((p.slope - m) * unit);
    put(p.wi);
    put(probes.area);
}
