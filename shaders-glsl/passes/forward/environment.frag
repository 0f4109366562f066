#version 460
#extension GL_GOOGLE_include_directive : require
// Computes the specular reflection of an environment by LEADR mapping on a grid of slopes (supplement, simplified Algorithm 1).
#include "slopes.glsl"
#include "leadr/integrals/specular.glsl"

layout(constant_id = 0) const int GRID = 5;

uniform samplerCube environment_cube;

void main() {
    Point point = shaded_point();
    Slopes slopes = filtered_slopes(point);
    float lambda = grid_lambda(GRID);
    vec3 cholesky = slope_cholesky(slopes.covariance);
    float base = env_lod_base(slopes.covariance, grid_spacing(GRID, lambda), forward.surface.z, LEADR_LOD_MATCHED);
    vec3 sum = vec3(0.0);
    float norm = 0.0;
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; k < GRID; ++k) {
            vec3 node = grid_node(j, k, GRID, lambda);
            EnvironmentSample e = environment_sample_at(point.wo, slope_at(node.xy, slopes.mean, cholesky));
            float weight = node.z * e.area;
            vec3 fresnel = fresnel_schlick(vec3(forward.surface.x), dot(point.wo, e.wn));
            vec3 incident = textureLod(environment_cube, from_frame(point.frame, e.wi), env_lod_at(base, point.wo, e.wn)).rgb;
            sum += weight * fresnel * incident;
            norm += weight;
        }
    }
    out_radiance = vec4(sum / max(norm, 1e-12), 1.0);
}
