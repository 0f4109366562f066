#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/tiling.glsl"
#include "probes/leadr_probe.glsl"

// A map of one wave, and its slope. The blend is continuous where the set of variants at a point changes.
vec3 example(const vec2 at) {
    vec2 phase = 6.28318530718 * at;
    return vec3(sin(phase.x + 2.0 * phase.y), 6.28318530718 * cos(phase.x + 2.0 * phase.y) * vec2(1.0, 2.0));
}

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    vec2 texcoord = next2();
    float cells = next();
    float lod = next();
    ivec2 corner = ivec2(floor(next2()));
    at = gl_GlobalInvocationID.x * 10;
    float part = tiling_fade(lod, 16.0, cells);
    TilingVariants variants = merged_variants(tiling_variants(texcoord, cells), lod);
    TilingVariant all[3] = TilingVariant[](variants.a, variants.b, variants.c);
    float height = 0.0, squares = 0.0;
    SlopeMoments blend = SlopeMoments(vec2(0.0), vec3(0.0));
    for (int i = 0; i < 3; ++i) {
        vec3 seen = example(fract(texcoord) + variant_offset(all[i].corner));
        height += all[i].weight * seen.x;
        squares += all[i].weight * all[i].weight;
        blend = add_variant(blend, SlopeMoments(seen.yz, vec3(90.0, 300.0, 120.0)), all[i].weight, part);
        blend.first += all[i].slope * seen.x;
    }
    put(height);
    put(squares);
    put(blend.first);
    put(blend.second);
    put(part);
    put(variant_offset(corner));
}
