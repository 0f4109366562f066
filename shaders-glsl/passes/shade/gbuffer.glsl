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
    vec3 position;       // world
    Frame frame;         // tangent frame, z the displacement direction
    vec3 wo;             // tangent frame, toward the viewer
    vec2 mean_slope;
    vec3 slope_covariance;
    vec3 albedo;
    float alpha;
    vec3 f0;             // reflectance at normal incidence
    float accessibility;
    bool inside;
    float relief;        // of an edge sample's object, metres
    float sunlit;        // the part of the pixel that the sun reaches, -1 where it is not known
};

// ray: of the pixel, to where its depth along the view axis is 1 / depth near planes.
Surface read_gbuffer(ivec2 pixel, vec3 eye, vec3 ray, float near, float depth) {
    Surface s;
    s.position = eye + ray * (near / depth);
    vec4 frame = texelFetch(gbuffer_frame, pixel, 0);
    s.frame = frame_about(octahedral_decode(frame.xy));
    s.wo = to_frame(s.frame, -normalize(ray));
    s.mean_slope = frame.zw;
    s.slope_covariance = texelFetch(gbuffer_covariance, pixel, 0).xyz;
    vec4 material = texelFetch(gbuffer_material, pixel, 0);
    s.albedo = material.rgb;
    s.alpha = material.a;
    vec4 surface = texelFetch(gbuffer_surface, pixel, 0);
    s.f0 = vec3(surface.x);
    s.accessibility = surface.y;
    s.inside = surface.z > 0.5;
    s.relief = surface.w;
    s.sunlit = -1.0;
    return s;
}

#endif
