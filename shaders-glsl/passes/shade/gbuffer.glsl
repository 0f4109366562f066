// Reading the G-buffer that the filter pass fills (src/render/filter.rs).
#ifndef LEADR_GBUFFER
#define LEADR_GBUFFER
#include "leadr/frame.glsl"

layout(binding = 0) uniform sampler2D gbuffer_frame;      // octahedral displacement direction, mean slope
layout(binding = 1) uniform sampler2D gbuffer_covariance; // sxx, syy, sxy, lod
layout(binding = 2) uniform sampler2D gbuffer_material;   // albedo, alpha
layout(binding = 3) uniform sampler2D gbuffer_surface;    // f0, accessibility, inside marker
layout(binding = 4) uniform sampler2D gbuffer_depth;      // reversed, 0 where nothing was drawn

struct Surface {
    bool hit;
    vec3 position;       // world
    vec3 wo;             // world, toward the viewer
    Frame frame;
    vec2 mean_slope;
    vec3 slope_covariance;
    vec3 albedo;
    float alpha;
    float f0;
    bool reflects;       // without any reflectance at normal incidence there is no interface, and none at other angles
    float accessibility;
    bool inside;
};

// rays: the viewing ray through ndc is rays[2] + ndc.x rays[0] + ndc.y rays[1]; near plane in rays[2].w.
Surface read_gbuffer(ivec2 pixel, vec2 ndc, vec3 eye, vec4 rays[3]) {
    Surface s;
    float depth = texelFetch(gbuffer_depth, pixel, 0).x;
    vec3 ray = rays[2].xyz + ndc.x * rays[0].xyz + ndc.y * rays[1].xyz;
    s.position = eye + ray * (rays[2].w / max(depth, 1e-9));
    s.wo = -normalize(ray);
    s.hit = depth > 0.0;
    vec4 frame = texelFetch(gbuffer_frame, pixel, 0);
    s.frame = frame_about(octahedral_decode(frame.xy));
    s.mean_slope = frame.zw;
    s.slope_covariance = texelFetch(gbuffer_covariance, pixel, 0).xyz;
    vec4 material = texelFetch(gbuffer_material, pixel, 0);
    s.albedo = material.rgb;
    s.alpha = material.a;
    vec4 surface = texelFetch(gbuffer_surface, pixel, 0);
    s.f0 = surface.x;
    s.reflects = surface.x > 0.0;
    s.accessibility = surface.y;
    s.inside = surface.z > 0.5;
    return s;
}

#endif
