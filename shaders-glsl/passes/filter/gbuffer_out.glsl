// Outputs of the fragment stages of the filter passes.
#ifndef LEADR_FILTER_GBUFFER_OUT
#define LEADR_FILTER_GBUFFER_OUT

#include "../bases.glsl"
#include "../gbuffer.glsl"

layout(location = 0) out uvec4 out_slopes;
layout(location = 1) out uvec4 out_material;
layout(location = 2) out uvec2 out_surface;
layout(location = 3) out uvec2 out_horizon;
layout(location = 4) out uvec4 out_reflection;
layout(location = 5) out uvec2 out_emission;

// Writes the G-buffer. surface is a texel from pack_surface, pack_edge or pack_joined_edge.
void write_gbuffer(const FilteredSurface f, const uvec2 surface) {
    out_slopes = pack_slopes(packSnorm2x16(octahedral_encode(f.normal)), f.mean_slope, f.covariance);
    out_material = pack_material(f.material, f.covariance);
    out_surface = surface;
    out_horizon = CONES && f.cone.w >= 0.0 ? pack_cone(f.cone) : pack_horizon(f.horizon);
    out_reflection = pack_reflection(f);
    out_emission = pack_emission(f);
}

#endif
