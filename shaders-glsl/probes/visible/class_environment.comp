#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/interreflection.glsl"
#include "leadr/visible/class_environment.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 45;
    vec3 wo = next3();
    vec3 albedo[4];
    for (int k = 0; k < 4; ++k) albedo[k] = next3();
    int classes = int(next());
    vec4 share = vec4(0.0);
    vec2 m[4];
    vec3 S[4];
    vec4 depth = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        float w = next();
        if (k < classes) share[k] = w;
        m[k] = next2();
        S[k] = next3();
        depth[k] = next();
    }
    share /= dot(share, vec4(1.0));
    int i = int(next());
    vec3 wi = i < LEADR_SKY_DIRECTIONS ? sky_direction(i) : ground_direction(i - LEADR_SKY_DIRECTIONS);
    wi = from_frame(sky_frame(normalize(vec3(-m[0], 1.0)), wo), wi);
    at = gl_GlobalInvocationID.x * 22;
    ClassSky sky = class_sky(classes, share, m, S, depth);
    for (int k = 0; k < 4; ++k) {
        put(mean_cosine(visible_diffuse_moments(wo, m[k], S[k], 3), wi));
        put(sky.area[k]);
        put(sky.flux[k]);
        put(sky.blocked[k]);
    }
    ReliefBounces bounces = relief_bounces(sky, albedo);
    // A nearly flat relief has a rounding error in its radiosity, of which it sees almost nothing.
    float sees = dot(sky.blocked, vec4(1.0));
    put(sees * relief_radiosity(bounces, vec3(1.0, 2.0, 3.0), sky.flux));
    put(sees * relief_radiosity(bounces, vec3(1.0), share));
}
