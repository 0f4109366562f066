#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a sample of the reference, shadows of the relief included: the base material on the facet that the pixel sees,
// under lights whose visibility comes from maps as fine as the relief. The environment is one light drawn from it.
#include "facet_frame.glsl"
#include "../constants.glsl"
#include "leadr/integrals/specular.glsl"
#include "leadr/visible/diffuse.glsl"
#include "leadr/visible/fresnel.glsl"

layout(constant_id = 5) const int TERMS = 15; // a bit per term of light transport
layout(constant_id = 31) const bool FACET_FRAME = false; // in which the base is rough

const int GRID = 5;          // samples of a mirror's slopes
const int DIFFUSE_TERMS = 2; // see leadr/visible/diffuse.glsl
const float BIAS = 1.0; // offset towards the light before the comparison, in texels of its map

struct Light {
    mat4 texture_from_world; // of its map: [0,1] texture coordinates and reversed depth
    mat4 world_from_texture;
    vec4 place; // xyz: towards it, or its position; w: 1 for a point light
    vec4 power; // rgb: irradiance on a plane facing it, or intensity; w: 1 for one drawn from the environment
    vec4 map;   // layer; world size of a texel, for a point light at distance 1; unused; 1 if it has a map
};

layout(std140) uniform Lighting {
    vec4 rays[3];         // see read_gbuffer
    vec4 camera_position; // xyz
    vec4 viewport;        // width, height, face size of the environment's cube, 1 when heights move the surface
    ivec4 counts;         // lights
    Light lights[MAX_RELIEF_LIGHTS];
} lighting;

uniform samplerCube environment_cube;
uniform sampler2DArray depth_maps;

layout(location = 0) in vec2 in_texcoord;
layout(location = 0) out vec4 out_radiance;

// Whether the light reaches a facet. The map holds depths at the centres of its texels, so the facet's plane is evaluated there
// too, not where the pixel met it: then a facet never shadows itself, at any angle.
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
    float limit = abs(further.z / further.w - s.z); // a plane seen edge-on can have any depth
    float slope = abs(plane.z) > 1e-20 ? -dot(plane.xy, offset) / plane.z : 0.0;
    return texelFetch(depth_maps, ivec3(at, int(light.map.x)), 0).x <= s.z + clamp(slope, -limit, limit);
}

// The environment in mirrors of slope covariance S.
vec3 mirrored(Surface surface, vec3 S) {
    float lambda = grid_lambda(GRID);
    vec2 m = face_viewer(surface.wo, surface.mean_slope, S, lambda);
    vec3 cholesky = slope_cholesky(S);
    float base = env_lod_base(S, grid_spacing(GRID, lambda), lighting.viewport.z, LEADR_LOD_MATCHED);
    float ao = max(meso_area(surface.wo, m), 0.0), visible = visible_area(surface.wo, m, S), norm = 0.0;
    vec3 sum = vec3(0.0);
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; k < GRID; ++k) {
            vec3 node = grid_node(j, k, GRID, lambda);
            EnvironmentSample e = environment_sample_at(surface.wo, slope_at(node.xy, m, cholesky));
            float weight = node.z * e.area;
            float lit = shadowing_from_areas(ao, visible, e.wi, m, S);
            float lod = env_lod_at(base, surface.wo, e.wn);
            sum += (weight * lit) * fresnel_schlick(surface.f0, dot(surface.wo, e.wn))
                 * textureLod(environment_cube, from_frame(surface.frame, e.wi), lod).rgb;
            norm += weight;
        }
    }
    return sum / max(norm, 1e-12);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 ndc = (gl_FragCoord.xy / lighting.viewport.xy) * 2.0 - 1.0;
    vec3 ray = lighting.rays[2].xyz + ndc.x * lighting.rays[0].xyz + ndc.y * lighting.rays[1].xyz;
    float depth = texelFetch(gbuffer_depth, pixel, 0).x;
    if (depth <= 0.0 || depth >= 1.0) { // see geometry.frag
        out_radiance = vec4(textureLod(environment_cube, ray, 0.0).rgb, 0.0);
        return;
    }
    Surface surface = read_gbuffer(pixel, lighting.camera_position.xyz, ray, lighting.rays[2].w, depth);
    if (surface.inside) {
        out_radiance = vec4(1.0, 0.0, 1.0, 1.0);
        return;
    }
    vec3 macronormal = surface.frame.z;
    if (FACET_FRAME) {
        surface = in_facet_frame(surface);
    }
    vec3 wo = surface.wo;
    vec2 m = surface.mean_slope;
    vec3 diffuse_s = surface.slope_covariance;
    vec3 specular_s = add_roughness(diffuse_s, surface.alpha);
    bool mirror = surface.alpha < MIRROR_ALPHA;
    vec3 radiance = mirror && (TERMS & TERM_SPECULAR_ENVIRONMENT) != 0 ? mirrored(surface, specular_s) : vec3(0.0);
    vec3 albedo = surface.albedo * (1.0 - visible_fresnel(wo, m, specular_s, surface.f0));
    // The plane that was drawn into the depth maps: the facet, or the smooth geometry where only normals are mapped.
    vec3 normal = lighting.viewport.w > 0.5 ? from_frame(surface.frame, normal_of_slope(m)) : macronormal;
    for (int i = 0; i < lighting.counts.x; ++i) {
        Light light = lighting.lights[i];
        vec3 towards = light.place.xyz, irradiance = light.power.rgb;
        if (light.place.w > 0.5) {
            vec3 d = towards - surface.position;
            float square = max(dot(d, d), 1e-8);
            towards = d * inversesqrt(square);
            irradiance /= square;
        }
        if (!reaches(light, surface.position, normal, towards)) {
            continue;
        }
        vec3 wi = to_frame(surface.frame, towards);
        bool drawn = light.power.w > 0.5;
        int terms = drawn ? TERMS >> 2 : TERMS;
        vec3 scattered = vec3(0.0);
        if ((terms & 2) != 0) {
            scattered += albedo * leadr_diffuse_light_visible(wo, wi, m, diffuse_s, false, DIFFUSE_TERMS);
        }
        if ((terms & 1) != 0 && !(mirror && drawn)) {
            scattered += leadr_specular_directional(wo, wi, m, specular_s, surface.f0, true);
        }
        radiance += irradiance * scattered;
    }
    out_radiance = vec4(radiance, 1.0);
}
