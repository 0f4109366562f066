#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a sample of the reference, with shadows of the relief: the base material on the facet at the pixel. Lights are the
// sun, point lights, lights of the panorama, and directions drawn from the environment, the facet's specular term and its
// hemisphere. Drawn directions are weighted by the density of all three (Veach's balance heuristic).
#include "air.glsl"
#include "facet_frame.glsl"
#include "gbuffer.glsl"
#include "../constants.glsl"
#include "../bases.glsl"
#include "draws.glsl"
#include "fitted_facets.glsl"
#include "point.glsl"
#include "visibility.glsl"
#include "leadr/integrals/specular.glsl"
#include "leadr/visible/diffuse.glsl"
#include "leadr/visible/fresnel.glsl"

layout(constant_id = 5) const int TERMS = 15; // a bit for each term of light transport
layout(constant_id = 31) const bool FACET_FRAME = false; // frame in which the base is rough
layout(constant_id = 81) const bool DISPLACED = true;    // whether heights move the surface
layout(constant_id = 82) const bool DRAWN = true;        // whether directions are drawn from the environment

const int SPECULAR_DRAWS = 8;
const int HEMISPHERE_DRAWS = 16;
const int DIFFUSE_TERMS = 2; // see leadr/visible/diffuse.glsl

uniform sampler2D visible_depth; // reversed, 0 where nothing was drawn
uniform samplerCube background_cube;
// The radiance of the environment, and the density of its draws relative to a face area of 2^2. Faces and rows are in the order of
// environment_lights.rs. The radiance is not filtered, because the weights require that all kinds of draws find the same light in a
// direction.
layout(std430) readonly buffer EnvironmentTexels { vec4 environment_texels[]; };

layout(location = 0) in vec2 in_texcoord;
layout(location = 0) out vec4 out_radiance;

// The effects that are enabled for one kind of light.
struct Transport {
    bool specular;
    bool diffuse;
};

Transport transport_of_lights() {
    return Transport((TERMS & TERM_SPECULAR_LIGHTS) != 0, (TERMS & TERM_DIFFUSE_LIGHTS) != 0);
}

Transport transport_of_environment() {
    return Transport((TERMS & TERM_SPECULAR_ENVIRONMENT) != 0, (TERMS & TERM_DIFFUSE_ENVIRONMENT) != 0);
}

// The material of the facet and the view direction, in the tangent frame.
struct Facet {
    vec3 wo;
    vec2 m;
    vec3 diffuse_s;
    vec3 specular_s;
    vec3 albedo; // albedo for the light that the specular term does not reflect
    vec3 f0;
    vec3 edge_tint; // F82 tint of a conductor's reflectance
    ComplexIndex index; // with EXACT_FRESNEL, of f0
    bool fitted; // whether the material is measured
    FittedFacet facet;
    float visible; // visible area of the specular lobe
    Frame frame;   // frame about the facet's normal
};

// Returns the radiance per unit of irradiance on a plane that faces wi.
vec3 scattered(const Facet facet, const vec3 wi, const Transport transport) {
    vec3 sum = vec3(0.0);
    if (transport.diffuse) {
        sum += facet.albedo * leadr_diffuse_light_visible(facet.wo, wi, facet.m, facet.diffuse_s, false, DIFFUSE_TERMS);
    }
    if (transport.specular && facet.fitted) {
        sum += fitted_reflected(facet.facet, wi);
    } else if (transport.specular) {
        sum += leadr_specular_directional(facet.wo, wi, facet.m, facet.specular_s, facet.f0, true)
             * fresnel_over_schlick(0u, facet.f0, facet.edge_tint, facet.index, 0.5 * length(facet.wo + wi));
    }
    return sum;
}

// Returns the radiance of the environment in a world direction. w is the density of the environment's draws per solid angle.
vec4 environment_at(const vec3 d) {
    vec3 a = abs(d);
    int face;
    vec3 p; // position on the face, and distance of the face's plane
    if (a.x >= a.y && a.x >= a.z) {
        face = d.x > 0.0 ? 0 : 1;
        p = vec3(d.x > 0.0 ? -d.z : d.z, -d.y, a.x);
    } else if (a.y >= a.z) {
        face = d.y > 0.0 ? 2 : 3;
        p = vec3(d.x, d.y > 0.0 ? d.z : -d.z, a.y);
    } else {
        face = d.z > 0.0 ? 4 : 5;
        p = vec3(d.z > 0.0 ? d.x : -d.x, -d.y, a.z);
    }
    vec2 st = p.xy / p.z;
    int size = lighting.counts.z;
    ivec2 texel = clamp(ivec2((st * 0.5 + 0.5) * float(size)), ivec2(0), ivec2(size - 1));
    float square = 1.0 + dot(st, st);
    vec4 light = environment_texels[(face * size + texel.y) * size + texel.x];
    return vec4(light.rgb, light.a * square * sqrt(square));
}

// Returns the expected number of draws of all kinds per solid angle in a direction. density is the density of the environment's draws. The
// number does not depend on the rendered terms, so that images of single terms add up.
float draws_per_angle(const Facet facet, const vec3 wi, const float density) {
    float sum = float(lighting.counts.y) * density
              + float(SPECULAR_DRAWS) * (facet.fitted ? fitted_density(facet.facet, wi)
                                                    : specular_density(facet.wo, wi, facet.m, facet.specular_s, facet.visible))
              + float(HEMISPHERE_DRAWS) * max(dot(wi, facet.frame.z), 0.0) / LEADR_PI;
    return max(sum, 1e-9);
}

// Returns the light of the environment from one drawn direction.
vec3 drawn_light(const Facet facet, const Surface surface, const vec3 normal, const vec3 wi, const Transport transport) {
    vec3 towards = from_frame(surface.frame, wi);
    if (HEIGHT_FIELD && !reaches_over_field(surface.position, normal, towards, 1e9)) {
        return vec3(0.0);
    }
    vec4 light = environment_at(towards);
    return scattered(facet, wi, transport) * light.rgb / draws_per_angle(facet, wi, light.a);
}

// Returns the environment's light from directions drawn from the facet's specular term and from its hemisphere.
vec3 drawn_environment(const Facet facet, const Surface surface, const vec3 normal) {
    Transport transport = transport_of_environment();
    if (!transport.specular && !transport.diffuse) {
        return vec3(0.0);
    }
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint lobe = draw_seed(pixel, lighting.seed.x, 0u), hemisphere = draw_seed(pixel, lighting.seed.x, 1u);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < SPECULAR_DRAWS; ++i) {
        vec2 u = drawn_point(uint(lighting.counts.w * SPECULAR_DRAWS + i), lobe);
        vec3 wi = facet.fitted ? fitted_direction_drawn(facet.facet, u)
                               : drawn_reflection(facet.wo, u, facet.m, facet.specular_s, facet.visible).wi;
        sum += drawn_light(facet, surface, normal, wi, transport);
    }
    for (int i = 0; i < HEMISPHERE_DRAWS; ++i) {
        vec2 u = drawn_point(uint(lighting.counts.w * HEMISPHERE_DRAWS + i), hemisphere);
        sum += drawn_light(facet, surface, normal, from_frame(facet.frame, drawn_cosine(u)), transport);
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 ndc = (gl_FragCoord.xy / lighting.viewport.xy) * 2.0 - 1.0;
    vec3 ray = lighting.rays[2].xyz + ndc.x * lighting.rays[0].xyz + ndc.y * lighting.rays[1].xyz;
    float depth = texelFetch(visible_depth, pixel, 0).x;
    if (depth <= 0.0 || depth >= 1.0) { // see geometry.frag
        out_radiance = vec4(textureLod(background_cube, ray, 0.0).rgb, 0.0);
        return;
    }
    FilteredSurface filtered = read_gbuffer(pixel, false);
    Surface surface = surface_at(filtered, lighting.camera_position.xyz, ray, lighting.rays[2].w, depth);
    if (surface.inside) {
        out_radiance = vec4(1.0, 0.0, 1.0, 1.0);
        return;
    }
    // For a height field, the drawn triangles are exact. For other casters, the facets come from the maps.
    bool drawn_facet = HEIGHT_FIELD && DISPLACED;
    if (drawn_facet) {
        vec3 facing = to_frame(surface.frame, field_normal(surface.position));
        surface.mean_slope = -facing.xy / max(facing.z, 1e-3);
    }
    vec3 macronormal = surface.frame.z;
    bool fitted = is_fitted(surface.fit);
    if (FACET_FRAME || fitted) {
        surface = in_facet_frame(surface);
    }
    // The drawn facet has only its own slope. The slopes of the map still give the direction of anisotropy.
    vec3 widest = surface.slope_covariance;
    if (drawn_facet) {
        surface.slope_covariance = vec3(0.0);
    }
    Facet facet;
    facet.wo = surface.wo;
    facet.m = surface.mean_slope;
    facet.diffuse_s = surface.slope_covariance;
    facet.specular_s = add_roughness(surface.slope_covariance, surface.alpha);
    facet.f0 = surface.f0;
    facet.edge_tint = surface.edge_tint;
    facet.index = surface.index;
    facet.fitted = fitted;
    if (fitted) {
        vec2 u = drawn_point(uint(lighting.counts.w), draw_seed(uvec2(pixel), lighting.seed.x, FACET_DRAW));
        vec3 normal = fitted_normal(surface.fit, facet.wo, facet.m, facet.diffuse_s, false, u);
        facet.facet = fitted_facet(surface.fit, surface.alpha, facet.wo, normal, widest);
    }
    vec3 fresnel = EXACT_FRESNEL ? visible_fresnel_exact(facet.wo, facet.m, facet.specular_s, surface.diffuse_f0, surface.diffuse_index)
                                 : visible_fresnel(facet.wo, facet.m, facet.specular_s, surface.diffuse_f0);
    facet.albedo = surface.albedo * (1.0 - fresnel);
    facet.visible = visible_area(facet.wo, facet.m, facet.specular_s);
    facet.frame = frame_about(normal_of_slope(facet.m));
    // The plane in the depth maps is the plane of the facet or, for normal maps, of the smooth geometry.
    vec3 normal = DISPLACED ? from_frame(surface.frame, facet.frame.z) : macronormal;
    vec3 radiance = DRAWN ? drawn_environment(facet, surface, normal) : vec3(0.0);
    // The depth adds nothing to the count. The depth prevents the loop bound from being a uniform (visibility.glsl).
    int lights = lighting.counts.x + int(depth);
    for (int i = 0; i < lights; ++i) {
        Light light = lighting.lights[i];
        vec3 towards = light.position.xyz, irradiance = light.power.rgb;
        float reach = 1e9;
        if (light.position.w > 0.5) {
            vec3 d = towards - surface.position;
            float square = max(dot(d, d), 1e-8);
            reach = sqrt(square);
            towards = d / reach;
            irradiance *= point_reach(towards, square, light.falloff, light.range.x) / square;
        }
        bool reached = HEIGHT_FIELD ? reaches_over_field(surface.position, normal, towards, reach)
                                         : reaches_by_map(light, surface.position, normal, towards);
        vec3 wi = to_frame(surface.frame, towards);
        int kind = int(light.power.w);
        if (kind != LIGHT_DRAWN) {
            Transport transport = kind == LIGHT_OF_SCENE ? transport_of_lights() : transport_of_environment();
            radiance += reached ? irradiance * scattered(facet, wi, transport) : vec3(0.0);
            continue;
        }
        Transport transport = transport_of_environment();
        float weight = light.map.z / draws_per_angle(facet, wi, light.map.z);
        if (HEIGHT_FIELD) {
            radiance += reached ? weight * irradiance * scattered(facet, wi, transport) : vec3(0.0);
            continue;
        }
        // Depth maps exist only for the directions of their lights, so the directions drawn above have no shadows. Here the shadowed part
        // of a light is subtracted, with the weight of the environment's own draws. The draws of the environment seldom hit narrow lobes,
        // so narrow lobes stay without shadows.
        radiance += weight * irradiance * scattered(facet, wi, transport);
        transport.specular = transport.specular && surface.alpha >= MIRROR_ALPHA;
        if (!reached) {
            radiance -= irradiance / float(lighting.counts.y) * scattered(facet, wi, transport);
        }
    }
    radiance += transport_of_lights().diffuse ? filtered.emission * lighting.camera_position.w : vec3(0.0);
    vec3 reach = surface.position - lighting.camera_position.xyz;
    out_radiance = vec4(through_air(radiance, reach, lighting.air.rgb, background_cube, lighting.viewport.z), 1.0);
}
