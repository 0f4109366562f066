// Reads the G-buffer that the filter pass fills.
#ifndef LEADR_READ_GBUFFER
#define LEADR_READ_GBUFFER
#include "../gbuffer.glsl"
#include "../bases.glsl"
#include "../technique.glsl"

uniform usampler2D gbuffer_slopes;
uniform usampler2D gbuffer_material;
uniform usampler2D gbuffer_surface;
uniform usampler2D gbuffer_horizon;
uniform usampler2D gbuffer_reflection;
uniform usampler2D gbuffer_emission;

// Pixels and edge samples have different data in the last texel. The values of the other kind are meaningless.
FilteredSurface read_gbuffer(const ivec2 pixel, const bool with_horizon) {
    uvec4 slopes = texelFetch(gbuffer_slopes, pixel, 0), material = texelFetch(gbuffer_material, pixel, 0);
    uvec2 surface = texelFetch(gbuffer_surface, pixel, 0).xy;
    FilteredSurface f;
    f.normal = octahedral_decode(unpackSnorm2x16(slopes.x));
    f.mean_slope = mean_slope_of(slopes);
    f.covariance = covariance_of(slopes, material);
    f.material = material_of(material);
    uvec4 reflection = texelFetch(gbuffer_reflection, pixel, 0);
    f.f0 = f0_of(reflection);
    f.diffuse_f0 = uintBitsToFloat(reflection.w);
    f.fit = fit_of(reflection);
    uvec2 emission = texelFetch(gbuffer_emission, pixel, 0).xy;
    f.emission = emission_of(emission);
    f.edge_tint = edge_tint_of(emission);
    f.medium = medium_number_of(reflection);
    f.coat = NO_COAT;
    if (COATED) {
        f.coat = coat_of(reflection, emission.y >> 31 != 0u);
    }
    vec2 accessibility_lod = unpackHalf2x16(surface.x);
    f.accessibility = max(accessibility_lod.x, 0.0);
    f.inside = accessibility_lod.x < 0.0;
    f.horizon = Horizon(vec2(0.0), vec3(0.0));
    f.cone = NO_CONE;
    if (with_horizon || CONES) {
        uvec2 packed = texelFetch(gbuffer_horizon, pixel, 0).xy;
        f.cone = CONES ? unpack_cone(packed) : NO_CONE;
        if (with_horizon && f.cone.w < 0.0) {
            f.horizon = unpack_horizon(packed);
        }
    }
    f.lod = accessibility_lod.y;
    f.joined = joined_part_of(surface);
    f.relief = uintBitsToFloat(surface.y);
    f.rotation = mat2(0.0);
    return f;
}

#endif
