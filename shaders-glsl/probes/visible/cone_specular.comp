#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/visible/cone_specular.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    float alpha = next();
    vec3 wo = next3();
    vec4 cone = vec4(next3(), 0.0);
    cone.w = next();
    at = gl_GlobalInvocationID.x * 5;
    put(cone_specular(alpha, wo, cone));
    put(lobe_in_cone(alpha, 3.0 * wo.z, 1.5 * cone.w));
    put(cone_table_texcoord(wo.z, alpha, cone.w));
}
