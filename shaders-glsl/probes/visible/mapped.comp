#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/facet_specular.glsl"
#include "leadr/visible/mapped.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    vec3 wo = next3();
    vec3 wi = next3();
    vec2 m = next2();
    vec3 relief = next3();
    float alpha = next();
    at = gl_GlobalInvocationID.x * 32;
    vec3 all = add_roughness(relief, alpha);
    float unit = max(all.x + all.y, 1e-8);
    MappedSlopes v = mapped_slopes(wo, m, relief, all);
    put(v.facing);
    put(v.relief);
    put(v.slopes.mean);
    put(v.slopes.cov / unit);
    put(v.slopes.facet);
    put(v.slopes.variance);
    put(v.slopes.area);
    put(mapped_fresnel(v, vec3(0.04)).x);
    NormalMoments n = mapped_diffuse_moments(m, relief, 2);
    put(n.mean);
    put(n.diag);
    put(n.off);
    put(mapped_diffuse_light(wi, m, relief, 2));
    put(mapped_specular_light(wo, wi, m, all, vec3(0.04)).x);
    VisibleProbes probes = mapped_probes(wo, v, probe_kernel(5));
    vec3 mean = vec3(0.0);
    float weight = 0.0, lod = 0.0, cosine = 0.0;
    for (int i = 0; i < 5; ++i) {
        VisibleProbe p = visible_probe(probes, wo, probe_node(5, i, probes.wide));
        mean += p.weight * p.wi * inversesqrt(max(dot(p.wi, p.wi), 1e-12));
        lod += p.weight * kernel_lod(p.variance, 256.0);
        cosine += p.weight * p.cosine;
    }
    put(mean);
    put(lod);
    put(cosine);
    FacetSpecular f = facet_specular(wo, wi, alpha, 0.0);
    put(facet_specular_density(f, m, slope_cholesky(relief), LEADR_SHADOWING_NORMAL_MAP));
    put(facet_visibility(LEADR_SHADOWING_NORMAL_MAP, wo.z, wi.z, dot(wo, wi), f.base));
    vec3 f0 = vec3(0.0, 0.04, 0.5);
    put(mapped_fresnel_exact(v, f0, complex_index(f0, vec3(3.0))));
}
