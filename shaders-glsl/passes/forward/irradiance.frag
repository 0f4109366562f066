#version 460
#extension GL_GOOGLE_include_directive : require
// Computes the diffuse light of an environment by LEADR mapping on a grid of slopes (supplement, simplified Algorithm 3).
#include "slopes.glsl"
#include "leadr/integrals/sh.glsl"

layout(constant_id = 0) const int GRID = 5;

void main() {
    Point point = shaded_point();
    Slopes slopes = filtered_slopes(point);
    // The roughness of the base affects the specular term only, so it is subtracted here.
    slopes.covariance.xy -= 0.5 * forward.material.w * forward.material.w;
    float lambda = grid_lambda(GRID);
    vec3 cholesky = slope_cholesky(slopes.covariance);
    vec3 c[9];
    for (int i = 0; i < 9; ++i) {
        c[i] = forward.radiance_sh[i].rgb;
    }
    vec3 sum = vec3(0.0);
    float norm = 0.0;
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; k < GRID; ++k) {
            vec3 node = grid_node(j, k, GRID, lambda);
            vec2 slope = slope_at(node.xy, slopes.mean, cholesky);
            float weight = node.z * facet_area(point.wo, slope);
            sum += weight * sh_irradiance(c, from_frame(point.frame, normal_of_slope(slope)));
            norm += weight;
        }
    }
    out_radiance = vec4(forward.material.rgb / LEADR_PI * sum / max(norm, 1e-12), 1.0);
}
