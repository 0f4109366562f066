#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a sample of the reference, shadows of the relief included: the base material on the facet that the pixel sees,
// under lights whose visibility comes from maps as fine as the relief. The environment is one light drawn from it.
#include "gbuffer.glsl"
#include "leadr/specular.glsl"
#include "leadr/diffuse.glsl"

// Base materials smoother than this mirror the environment as if nothing shadowed it: drawn lights would miss them.
layout(constant_id = 0) const float MIRROR_ALPHA = 0.15;

const int GRID = 5; // samples of the base material's slopes
const int MAX_LIGHTS = 6;
const float BIAS = 1.0; // steps towards the light before looking, in texels of its map

struct Light {
    mat4 texture_from_world; // of its map: [0,1] texture coordinates and reversed depth
    mat4 world_from_texture;
    vec4 place; // xyz: towards it, or its position; w: 1 for a point light
    vec4 power; // rgb: irradiance on a plane facing it, or intensity; w: 1 for one drawn from the environment
    vec4 map;   // layer; world size of a texel, for a point light at distance 1; unused; 1 if it has a map
};

layout(binding = 5, std140) uniform Lighting {
    vec4 rays[3];         // see read_gbuffer
    vec4 camera_position; // xyz
    vec4 viewport;        // width, height, face size of the environment's cube
    ivec4 counts;         // lights
    Light lights[MAX_LIGHTS];
} lighting;

layout(binding = 6) uniform samplerCube environment_cube;
layout(binding = 7) uniform sampler2DArray depth_maps;

layout(location = 0) in vec2 in_texcoord;
layout(location = 0) out vec4 out_radiance;

// Whether the light reaches a facet. The map holds depths at the centres of its texels, so the facet's plane is asked for
// its depth there too, not where the pixel met it: a facet shadows itself at no angle.
bool reaches(Light light, vec3 position, vec3 normal, vec3 towards) {
    if (light.map.w < 0.5) {
        return true;
    }
    float texel = light.map.y * (light.place.w > 0.5 ? distance(light.place.xyz, position) : 1.0);
    vec3 lifted = position + towards * (texel * BIAS);
    vec4 s = light.texture_from_world * vec4(lifted, 1.0);
    vec4 further = light.texture_from_world * vec4(position + towards * (8.0 * texel), 1.0);
    s.xyz /= s.w;
    if (s.w <= 0.0 || any(lessThan(s.xy, vec2(0.0))) || any(greaterThanEqual(s.xy, vec2(1.0)))) {
        return true;
    }
    vec2 size = vec2(textureSize(depth_maps, 0).xy);
    ivec2 at = ivec2(s.xy * size);
    vec2 offset = (vec2(at) + 0.5) / size - s.xy;
    vec4 plane = vec4(normal, -dot(normal, lifted)) * light.world_from_texture;
    float limit = abs(further.z / further.w - s.z); // planes seen edge-on have any depth
    float slope = abs(plane.z) > 1e-20 ? -dot(plane.xy, offset) / plane.z : 0.0;
    return texelFetch(depth_maps, ivec3(at, int(light.map.x)), 0).x <= s.z + clamp(slope, -limit, limit);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 ndc = (gl_FragCoord.xy / lighting.viewport.xy) * 2.0 - 1.0;
    Surface surface = read_gbuffer(pixel, ndc, lighting.camera_position.xyz, lighting.rays);
    if (!surface.hit) {
        out_radiance = vec4(textureLod(environment_cube, -surface.wo, 0.0).rgb, 0.0);
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
    bool mirror = surface.alpha < MIRROR_ALPHA;

    // What the base material's facets reflect on the whole; a mirror's environment comes from the same walk.
    vec3 reflected = vec3(0.0), fresnel = vec3(0.0);
    float norm = 0.0;
    vec3 cholesky = slope_cholesky(specular_s);
    float lod_base = env_lod_base(specular_s, grid_spacing(GRID, lambda), lighting.viewport.z, LEADR_LOD_MATCHED);
    float ao = max(meso_area(wo, specular_m), 0.0);
    float visible_o = visible_area(wo, specular_m, specular_s);
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; k < GRID; ++k) {
            vec3 node = grid_node(j, k, GRID, lambda);
            EnvironmentSample e = environment_sample_at(wo, slope_at(node.xy, specular_m, cholesky));
            float weight = node.z * e.area;
            vec3 f = fresnel_schlick(f0, dot(wo, e.wn));
            fresnel += weight * f;
            norm += weight;
            if (mirror) {
                float lit = shadowing_from_areas(ao, visible_o, e.wi, specular_m, specular_s);
                float lod = env_lod_at(lod_base, wo, e.wn);
                reflected += weight * lit * f * textureLod(environment_cube, from_frame(frame, e.wi), lod).rgb;
            }
        }
    }
    float inverse_norm = 1.0 / max(norm, 1e-12);
    vec3 radiance = reflected * inverse_norm;
    vec3 albedo = surface.albedo * (1.0 - fresnel * inverse_norm);

    vec3 normal = from_frame(frame, normal_of_slope(surface.mean_slope));
    for (int i = 0; i < lighting.counts.x; ++i) {
        Light light = lighting.lights[i];
        vec3 towards = light.place.xyz, irradiance = light.power.rgb;
        if (light.place.w > 0.5) {
            vec3 d = towards - surface.position;
            float square = max(dot(d, d), 1e-8);
            towards = d * inversesqrt(square);
            irradiance /= square;
        }
        if (dot(normal, towards) <= 0.0 || !reaches(light, surface.position, normal, towards)) {
            continue;
        }
        vec3 wi = to_frame(frame, towards);
        vec3 scattered = albedo * leadr_diffuse_light(wo, wi, diffuse_m, diffuse_s, false, GRID, lambda);
        if (!(mirror && light.power.w > 0.5)) {
            scattered += leadr_specular_directional(wo, wi, specular_m, specular_s, f0, true);
        }
        radiance += irradiance * scattered;
    }
    out_radiance = vec4(radiance, 1.0);
}
