#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/masking/occlusion.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 12;
    float visibility = next();
    vec3 albedo = next3();
    vec4 cone = vec4(next3(), 0.0);
    cone.w = next();
    vec3 wi = next3();
    float gloss = next();
    at = gl_GlobalInvocationID.x * 49;
    for (int hidden = 0; hidden < 5; ++hidden) put(adjusted_visibility(hidden, visibility, albedo));
    put(cone_cosine(visibility));
    put(cone_visibility(cone.w));
    put(bent_cone_visibility(cone));
    put(bent_cone(visibility, cone.xyz).w);
    put(bent_cone_cosine(visibility, cone.xyz));
    put(cone_light(cone, wi));
    put(cone_light_smooth(cone, wi));
    put(adjusted_cone_cosine(cone.w, gloss, wi.z, false, 8));
    put(adjusted_cone_cosine(cone.w, gloss, wi.z, true, 6));
    put(interreflected_visibility(visibility, albedo).x);
    put(cone_of_vector(0.5 * visibility * cone.xyz).xyz);
    put(cone_of_vector(0.5 * visibility * cone.xyz).w);
    for (int edge = 0; edge < 4; ++edge) put(cone_light_by_edge(edge, cone, wi));
    for (int lobe = 0; lobe < 4; ++lobe) {
        vec4 found = cone_of_lobe(lobe, cone, visibility, gloss, wi.z);
        put(found.xyz);
        put(found.w);
    }
}
