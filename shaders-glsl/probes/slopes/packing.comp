#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/packing.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 8;
    SlopeMoments a;
    a.first = next2();
    a.second = next3();
    float height = next();
    float limit = next();
    float levels = next();
    at = gl_GlobalInvocationID.x * 32;
    put(principal_variances(a.second));
    vec4 p;
    vec2 q;
    pack_leadr(a, height, p, q);
    put(p.xy);
    put(p.zw);
    put(q);
    float h;
    SlopeMoments b = unpack_leadr(p, q, h);
    put(b.first);
    put(b.second);
    put(h);
    float lean[5] = pack_lean(a, limit);
    for (int i = 0; i < 5; ++i) put(lean[i]);
    b = unpack_lean(lean, limit);
    put(b.first);
    put(b.second);
    put(lean_error(limit, levels));
    put(pack_clean(a).z);
    put(pack_clean_major(a).z);
    put(pack_clean_conservative(a).z);
    put(clean_covariance(vec3(a.first, a.second.x)).xy);
    put(clean_conservative_covariance(vec3(a.first, a.second.x)).xy);
}
