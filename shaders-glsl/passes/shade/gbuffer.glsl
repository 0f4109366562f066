// Reads the G-buffer that the filter pass fills.
#ifndef LEADR_READ_GBUFFER
#define LEADR_READ_GBUFFER
#include "../gbuffer.glsl"
#include "leadr/frame.glsl"

uniform usampler2D gbuffer_slopes;
uniform usampler2D gbuffer_material;
uniform usampler2D gbuffer_surface;
uniform sampler2D gbuffer_depth; // reversed, 0 where nothing was drawn

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
    float relief;        // of the object of an edge sample, metres
    float sunlit;        // fraction of the joined edge samples that the first sun reaches
    vec4 more_sunlit;    // and the others
    float joined;        // weight of `sunlit`, 0 to 1
    Horizon horizon;     // of its relief
};

// ray: through the pixel, scaled so that the surface lies at ray * near / depth.
Surface read_gbuffer(ivec2 pixel, vec3 eye, vec3 ray, float near, float depth) {
    Surface s;
    s.position = eye + ray * (near / depth);
    uvec4 slopes = texelFetch(gbuffer_slopes, pixel, 0), material = texelFetch(gbuffer_material, pixel, 0);
    uvec2 surface = texelFetch(gbuffer_surface, pixel, 0).xy;
    s.frame = frame_about(octahedral_decode(unpackSnorm2x16(slopes.x)));
    s.wo = to_frame(s.frame, -normalize(ray));
    s.mean_slope = mean_slope_of(slopes);
    s.slope_covariance = covariance_of(slopes, material);
    vec4 color = material_of(material);
    s.albedo = color.rgb;
    s.alpha = color.a;
    vec2 f0_access = unpackHalf2x16(surface.x);
    s.f0 = vec3(f0_access.x);
    s.accessibility = f0_access.y;
    s.inside = f0_access.x < 0.0;
    s.relief = uintBitsToFloat(surface.y);
    s.sunlit = 0.0;
    s.more_sunlit = vec4(0.0);
    s.joined = 0.0;
    s.horizon = Horizon(vec2(0.0), vec3(0.0));
    return s;
}

#endif
