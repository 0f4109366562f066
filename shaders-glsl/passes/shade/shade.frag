#version 460
#extension GL_GOOGLE_include_directive : require
// Shades each pixel of the G-buffer once: LEADR eq. 17 (specular, one light), eq. 19 by Algorithm 1 (specular,
// environment) and eq. 20-21 by Algorithms 2 and 3 (diffuse).
#include "gbuffer.glsl"
#include "leadr/specular.glsl"
#include "leadr/diffuse.glsl"

layout(constant_id = 0) const int GRID = 5;             // N of the N x N slope samples
layout(constant_id = 1) const int VISIBILITY = 1;       // masking, Smith, correlated
layout(constant_id = 2) const bool LIGHTS_BY_SH = false; // diffuse lights through order-2 SH as in Algorithm 2
layout(constant_id = 3) const int TERMS = 15;            // which light counts

const bool SHADOWING = VISIBILITY != 0;

const int MAX_POINT_LIGHTS = 4;

layout(binding = 5, std140) uniform Lighting {
    vec4 rays[3];                 // see read_gbuffer
    mat4 shadow_from_world;       // to [0,1] texture coordinates and depth
    vec4 camera_position;         // xyz
    vec4 sun_direction;           // xyz toward the sun; w 1 when there is one
    vec4 sun_irradiance;          // rgb on a plane facing it
    vec4 point_position[MAX_POINT_LIGHTS];  // xyz
    vec4 point_intensity[MAX_POINT_LIGHTS]; // rgb
    vec4 viewport;                // width, height
    vec4 environment;             // x: face size of the cube, y: scale, z: shadow texel in world units, w: 1 when shadows are on
    ivec4 counts;                 // x: point lights
} lighting;

layout(binding = 6) uniform samplerCube environment_cube;
layout(binding = 7, std430) readonly buffer Irradiance { vec4 radiance_sh[9]; };
layout(binding = 8) uniform sampler2D shadow_map;

layout(location = 0) in vec2 in_texcoord;
layout(location = 0) out vec4 out_radiance;

// Fraction of the sun seen by the macro surface: 4 x 4 comparisons, bilinearly weighted.
float sun_visibility(vec3 position, vec3 normal) {
    if (lighting.environment.w < 0.5) {
        return 1.0;
    }
    float texel = lighting.environment.z;
    float sine = sqrt(max(1.0 - pow(dot(normal, lighting.sun_direction.xyz), 2.0), 0.0));
    vec3 lifted = position + normal * texel * (1.0 + 2.0 * sine);
    vec3 s = (lighting.shadow_from_world * vec4(lifted, 1.0)).xyz;
    if (any(lessThan(s, vec3(0.0))) || any(greaterThan(s, vec3(1.0)))) {
        return 1.0;
    }
    vec2 size = vec2(textureSize(shadow_map, 0));
    vec2 position_texels = s.xy * size - 0.5;
    vec2 base = floor(position_texels), fraction = position_texels - base;
    float lit = 0.0;
    for (int y = -1; y <= 2; ++y) {
        for (int x = -1; x <= 2; ++x) {
            float depth = texelFetch(shadow_map, clamp(ivec2(base) + ivec2(x, y), ivec2(0), ivec2(size) - 1), 0).x;
            float wx = x == -1 ? 1.0 - fraction.x : (x == 2 ? fraction.x : 1.0);
            float wy = y == -1 ? 1.0 - fraction.y : (y == 2 ? fraction.y : 1.0);
            lit += depth <= s.z ? wx * wy : 0.0;
        }
    }
    return lit / 9.0;
}

struct Light {
    vec3 direction;  // world, toward the light
    vec3 irradiance; // on a plane facing it
};

Light point_light(int i, vec3 position) {
    vec3 d = lighting.point_position[i].xyz - position;
    float square = max(dot(d, d), 1e-8);
    return Light(d * inversesqrt(square), lighting.point_intensity[i].rgb / square);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 ndc = (gl_FragCoord.xy / lighting.viewport.xy) * 2.0 - 1.0;
    Surface surface = read_gbuffer(pixel, ndc, lighting.camera_position.xyz, lighting.rays);
    float environment_scale = lighting.environment.y;
    if (!surface.hit) {
        out_radiance = vec4(textureLod(environment_cube, -surface.wo, 0.0).rgb * environment_scale, 0.0);
        return;
    }
    if (surface.inside) {
        out_radiance = vec4(1.0, 0.0, 1.0, 1.0);
        return;
    }

    Frame frame = surface.frame;
    vec3 wo = to_frame(frame, surface.wo);
    float lambda = grid_lambda(GRID);
    vec3 diffuse_s = surface.slope_covariance;
    vec3 specular_s = add_roughness(diffuse_s, surface.alpha);
    vec2 diffuse_m = face_viewer(wo, surface.mean_slope, diffuse_s, lambda);
    vec2 specular_m = face_viewer(wo, surface.mean_slope, specular_s, lambda);
    vec3 f0 = vec3(surface.f0);

    vec3 ambient = vec3(surface.accessibility * environment_scale);
    // Specular, environment: Algorithm 1, with what does not change from sample to sample taken out of the loop.
    vec3 reflected = vec3(0.0), fresnel = vec3(0.0);
    float norm = 0.0;
    vec3 cholesky = slope_cholesky(specular_s);
    float lod_base = env_lod_base(specular_s, grid_spacing(GRID, lambda), lighting.environment.x, LEADR_LOD_MATCHED);
    float ao = max(meso_area(wo, specular_m), 0.0);
    float visible_o = visible_area(wo, specular_m, specular_s);
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; k < GRID; ++k) {
            vec3 node = grid_node(j, k, GRID, lambda);
            EnvironmentSample e = environment_sample_at(wo, slope_at(node.xy, specular_m, cholesky));
            float weight = node.z * e.area;
            float lit = SHADOWING ? shadowing_from_areas(ao, visible_o, e.wi, specular_m, specular_s) : 1.0;
            vec3 incident = textureLod(environment_cube, from_frame(frame, e.wi), env_lod_at(lod_base, wo, e.wn)).rgb;
            vec3 f = fresnel_schlick(f0, dot(wo, e.wn));
            fresnel += weight * f;
            reflected += weight * lit * f * incident;
            norm += weight;
        }
    }
    vec3 radiance = ambient * reflected / max(norm, 1e-12);
    // What the visible facets do not reflect enters the surface and is what the diffuse term may return.
    vec3 albedo = surface.albedo * (1.0 - fresnel / max(norm, 1e-12));

    NormalMoments normals = visible_normal_moments(wo, diffuse_m, diffuse_s, GRID, lambda);
    vec3 coefficients[9];
    for (int i = 0; i < 9; ++i) {
        coefficients[i] = radiance_sh[i].rgb;
    }
    radiance += albedo * ambient * leadr_diffuse_environment(normals, frame, coefficients);

    // Directional and point lights.
    vec3 mesonormal = from_frame(frame, normal_of_slope(surface.mean_slope));
    for (int i = 0; i <= lighting.counts.x; ++i) {
        Light light = i == 0 ? Light(lighting.sun_direction.xyz, lighting.sun_irradiance.rgb) : point_light(i - 1, surface.position);
        if (i == 0) {
            light.irradiance *= lighting.sun_direction.w * sun_visibility(surface.position, mesonormal);
        }
        vec3 wi = to_frame(frame, light.direction);
        float diffuse = LIGHTS_BY_SH
            ? leadr_diffuse_light_sh(normals, wo, wi, diffuse_m, diffuse_s, SHADOWING)
            : leadr_diffuse_light(wo, wi, diffuse_m, diffuse_s, SHADOWING, GRID, lambda);
        vec3 specular = leadr_specular_directional(wo, wi, specular_m, specular_s, f0, SHADOWING);
        radiance += light.irradiance * (albedo * diffuse + specular);
    }

    out_radiance = vec4(radiance, 1.0);
}
