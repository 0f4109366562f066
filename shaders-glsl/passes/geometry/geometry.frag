#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"
#include "tile.glsl"
#include "leadr/frame.glsl"
#include "leadr/slope_map.glsl"

layout(constant_id = 0) const int TECHNIQUE = 0; // the TECHNIQUE_ values below
layout(constant_id = 1) const int MAX_TAPS = 8;  // taps along the long axis of the pixel's footprint

const int TECHNIQUE_LEADR = 0;
const int TECHNIQUE_NORMAL_MIP = 1; // mean slope only
const int TECHNIQUE_REFERENCE = 2;  // finest level: supersampling does the filtering

layout(location = 0) in vec3 in_normal;
layout(location = 1) in vec3 in_tangent_s;
layout(location = 2) in vec3 in_tangent_t;
layout(location = 3) in vec2 in_texcoord;
layout(location = 4) in vec4 in_color;
layout(location = 5) in float in_accessibility;
layout(location = 6) in flat uint in_patch;

layout(location = 0) out vec4 out_frame;      // octahedral displacement direction, mean slope
layout(location = 1) out vec4 out_covariance; // sxx, syy, sxy of the slopes; LOD
layout(location = 2) out vec4 out_material;   // linear albedo, Beckmann roughness alpha
layout(location = 3) out vec4 out_surface;    // specular f0, ambient accessibility, inside marker, unused

struct Footprint {
    vec2 step; // between taps, texture coordinates
    int taps;
    float lod;
};

// Moments are linear, so the elliptical footprint of a pixel is a few isotropic taps along its long axis.
Footprint pixel_footprint(vec2 texcoord, ivec2 size) {
    vec2 dx = dFdx(texcoord), dy = dFdy(texcoord);
    vec2 tx = dx * vec2(size), ty = dy * vec2(size);
    float xx = dot(tx, tx), yy = dot(ty, ty);
    vec2 along = xx > yy ? dx : dy;
    float major = sqrt(max(xx, yy));
    // The width across the long axis: the area of the footprint over its length.
    float minor = abs(tx.x * ty.y - tx.y * ty.x) / max(major, 1e-20);
    Footprint footprint;
    footprint.taps = clamp(int(ceil(major / max(minor, 1.0))), 1, MAX_TAPS);
    footprint.step = along / float(footprint.taps);
    footprint.lod = max(log2(max(major / float(footprint.taps), minor)), 0.0);
    return footprint;
}

void main() {
    vec3 normal = normalize(in_normal);
    Frame frame = frame_about(normal);

    // Derivatives before any branch.
    vec3 normal_dx = dFdx(normal), normal_dy = dFdy(normal);
    ivec2 size = textureSize(moments_b, 0);
    ivec2 color_size = textureSize(color_map, 0);
    Footprint footprint = pixel_footprint(in_texcoord, size);
    Footprint color_footprint = pixel_footprint(in_texcoord, color_size);
    bool reference = TECHNIQUE == TECHNIQUE_REFERENCE;
    if (reference) {
        footprint = Footprint(vec2(0.0), 1, 0.0);
        color_footprint = footprint;
    }
    vec4 tile = patches[in_patch].tile;

    vec2 mean_gradient = vec2(0.0);
    vec3 gradient_covariance = vec3(0.0);
    if ((object.flags & FLAG_DISPLACED) != 0u) {
        vec4 a = vec4(0.0);
        float b = 0.0;
        for (int i = 0; i < footprint.taps; ++i) {
            vec2 tap = in_texcoord + footprint.step * (float(i) + 0.5 - 0.5 * float(footprint.taps));
            tap = clamp_to_tile(tap, tile, footprint.lod, size);
            a += textureLod(moments_a, tap, footprint.lod);
            b += textureLod(moments_b, tap, footprint.lod).x;
        }
        float weight = 1.0 / float(footprint.taps);
        gradient_covariance = covariance_from_moments(a.xy * weight, vec3(a.zw, b) * weight);
        gradient_covariance = scale_height(gradient_covariance, object.height_scale);
        mean_gradient = a.xy * (weight * object.height_scale);
    }
    SlopeMap map = slope_map(in_tangent_s, in_tangent_t, frame.x, frame.y, frame.z);
    vec2 mean_slope = map_mean_slope(map, mean_gradient);
    vec3 covariance = vec3(0.0);
    if (TECHNIQUE != TECHNIQUE_NORMAL_MIP) {
        // At the finest level this is the spread between neighbouring texels, which bilinear interpolation of the
        // mean leaves out: with it the variance is the same at every magnification.
        covariance = map_covariance(map, gradient_covariance);
    }
    if (TECHNIQUE == TECHNIQUE_LEADR) {
        // The turn of the macro normal over one pixel, as a difference of slopes.
        vec2 slope_dx = -to_frame(frame, normal_dx).xy;
        vec2 slope_dy = -to_frame(frame, normal_dy).xy;
        covariance = add_macro_curvature(covariance, slope_dx, slope_dy);
    }

    vec4 color = in_color;
    if ((object.flags & FLAG_COLOR_MAP) != 0u) {
        vec4 texel = vec4(0.0);
        for (int i = 0; i < color_footprint.taps; ++i) {
            vec2 tap = in_texcoord + color_footprint.step * (float(i) + 0.5 - 0.5 * float(color_footprint.taps));
            texel += textureLod(color_map, clamp_to_tile(tap, tile, color_footprint.lod, color_size), color_footprint.lod);
        }
        color *= texel / float(color_footprint.taps); // the vertex colour tints the map
    }

    out_frame = vec4(octahedral_encode(normal), mean_slope);
    out_covariance = vec4(covariance, footprint.lod);
    out_material = color;
    bool inside = (object.flags & FLAG_MARK_INSIDE) != 0u && !gl_FrontFacing;
    out_surface = vec4(object.specular_f0, in_accessibility, inside ? 1.0 : 0.0, 0.0);
}
