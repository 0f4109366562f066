#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Shades each pixel of the G-buffer once.
#include "gbuffer.glsl"
#include "shaded.glsl"
#include "../edges/edges.glsl"
#include "../visible.glsl"

uniform usampler2D visible_surface;
uniform sampler2D visible_depth; // reversed, 0 where nothing was drawn
uniform sampler2D shares;     // output of join.comp
uniform sampler2D more_suns;  // output of join.comp

layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (EDGES == EDGES_ARE_SHADED) {
        uint word = texelFetch(visible_surface, pixel, 0).x;
        if (word == SURFACE_OF_THE_PIXEL || (word & OF_THE_PIXEL) != 0u) {
            out_radiance = vec4(0.0);
            return;
        }
    }
    vec3 ray = pixel_ray(gl_FragCoord.xy);
    float depth = texelFetch(visible_depth, pixel, 0).x;
    if (depth <= 0.0 || depth >= 1.0) { // see geometry.frag
        // The sky pass (sky.frag) draws the sky behind pixels, because lavapipe would look up the sky for every pixel here.
        out_radiance = EDGES == EDGES_ARE_SHADED ? vec4(sky_radiance(ray), 0.0) : vec4(0.0);
        return;
    }
    FilteredSurface filtered = read_gbuffer(pixel, USES_HORIZON);
    Surface surface = surface_seen(filtered, gl_FragCoord.xy, depth);
    if (EDGES == EDGES_ARE_JOINED) {
        vec4 share = texelFetch(shares, pixel, 0);
        if (share.z > 0.0) {
            surface.sunlit = share.w / share.z;
            if (SUNS > 1) {
                surface.more_sunlit = texelFetch(more_suns, pixel, 0) / share.z;
            }
            surface.joined = filtered.joined;
        }
    }
    out_radiance = vec4(surface_radiance(surface), 1.0);
}
