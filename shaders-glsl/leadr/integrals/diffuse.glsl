#ifndef LEADR_DIFFUSE_GLSL
#define LEADR_DIFFUSE_GLSL

#include "../frame.glsl"
#include "../masking/grooves.glsl"
#include "../masking/smith.glsl"
#include "sh.glsl"
#include "../slopes/grid.glsl"

// Computes the diffuse radiance of the visible facets per unit of albedo on an n x n grid of slopes (LEADR eq. 23, Algorithm 3). The sum
// over the grid is divided by the sum of the visible areas, which is the masking term (supplement, eq. 10). Apply face_viewer to m first.

// The first and second moments of the visible normals in the tangent frame. Order-2 irradiance is linear in the moments, so one pass over
// the grid serves the environment and every light.
struct NormalMoments {
    vec3 mean; // E[n]
    vec3 diag; // E[n.x^2], E[n.y^2], E[n.z^2]
    vec3 off;  // E[n.y n.z], E[n.x n.z], E[n.x n.y]
};

// Returns the moments over facets that show an area of at most `most`.
NormalMoments normal_moments_up_to(const float most, const vec3 wo, const vec2 m, const vec3 S, const int n, const float lambda) {
    NormalMoments sum = NormalMoments(vec3(0.0), vec3(0.0), vec3(0.0));
    float norm = 0.0;
    vec3 cholesky = slope_cholesky(S);
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
            vec3 node = grid_node(j, k, n, lambda);
            vec2 slope = slope_at(node.xy, m, cholesky);
            vec3 wn = normal_of_slope(slope);
            float w = node.z * min(facet_area(wo, slope), most);
            sum.mean += w * wn;
            sum.diag += w * wn * wn;
            sum.off += w * wn.yzx * wn.zxy;
            norm += w;
        }
    float scale = 1.0 / max(norm, 1e-12);
    return NormalMoments(sum.mean * scale, sum.diag * scale, sum.off * scale);
}

NormalMoments visible_normal_moments(const vec3 wo, const vec2 m, const vec3 S, const int n, const float lambda) {
    return normal_moments_up_to(1e30, wo, m, S, n, lambda);
}

// Returns the same for V-grooves.
NormalMoments groove_normal_moments(const vec3 wo, const vec2 m, const vec3 S, const int n, const float lambda) {
    return normal_moments_up_to(groove_visible_area(1e30, meso_area(wo, m)), wo, m, S, n, lambda);
}

// Returns the radiance under an environment, with masking only (as in Algorithm 2). c has the coefficients of the radiance in world space,
// and f is the tangent frame. `rest` is the irradiance of orders above 2 for these normals, or 0.
vec3 leadr_diffuse_environment(const NormalMoments v, const Frame f, const vec3 c[9], const vec3 rest) {
    mat3 r = mat3(f.x, f.y, f.z);
    mat3 t = mat3(v.diag.x, v.off.z, v.off.y, v.off.z, v.diag.y, v.off.x, v.off.y, v.off.x, v.diag.z);
    mat3 q = r * t * transpose(r);
    vec3 e = sh_irradiance_moments(c, r * v.mean, vec3(q[0].x, q[1].y, q[2].z), vec3(q[2].y, q[2].x, q[1].x));
    return max(e + rest, 0.0) / LEADR_PI;
}

// Returns the radiance under one light from wi (tangent frame), whose irradiance on a plane facing it is 1. The light's order-2 harmonics
// (Algorithm 2) are weighted by masking and shadowing of the light (eq. 20). The paper states an error of up to 9 %. The result is clamped
// to at least 0.
float leadr_diffuse_light_sh(const NormalMoments v, const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const bool shadowing) {
    float second = dot(wi * wi, v.diag) + 2.0 * dot(wi.yzx * wi.zxy, v.off);
    float e = 0.09375 * (v.diag.x + v.diag.y + v.diag.z) + 0.5 * dot(wi, v.mean) + 0.46875 * second;
    return shadowing_given_masking(wo, wi, m, S, shadowing) * max(e, 0.0) / LEADR_PI;
}

// Returns the radiance under one light. The clamped cosine of the light is integrated over the grid, so use this function for a sun.
float leadr_diffuse_light(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const bool shadowing, const int n, const float lambda) {
    float sum = 0.0;
    float norm = 0.0;
    vec3 cholesky = slope_cholesky(S);
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
            vec3 node = grid_node(j, k, n, lambda);
            vec2 slope = slope_at(node.xy, m, cholesky);
            float w = node.z * facet_area(wo, slope);
            sum += w * max(dot(wi, normal_of_slope(slope)), 0.0);
            norm += w;
        }
    return shadowing_given_masking(wo, wi, m, S, shadowing) * sum / max(norm, 1e-12) / LEADR_PI;
}

// Returns the same for V-grooves, which shadow each facet by itself.
float groove_diffuse_light(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const int n, const float lambda) {
    float sum = 0.0;
    float norm = 0.0;
    vec3 cholesky = slope_cholesky(S);
    float ao = meso_area(wo, m), ai = meso_area(wi, m);
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
            vec3 node = grid_node(j, k, n, lambda);
            vec2 slope = slope_at(node.xy, m, cholesky);
            float facet = facet_area(wo, slope);
            float w = node.z * groove_visible_area(facet, ao);
            sum += w * groove_lit_fraction(facet, facet_area(wi, slope), ao, ai) * max(dot(wi, normal_of_slope(slope)), 0.0);
            norm += w;
        }
    return sum / max(norm, 1e-12) / LEADR_PI;
}

#endif
