#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/slopes/moments.glsl"
#include "probes/leadr_probe.glsl"

void put(const SlopeMoments a) { put(a.first); put(a.second); }

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 17;
    vec2 m = next2();
    vec3 S = next3();
    vec3 n = next3();
    vec2 shear = next2();
    vec2 column = next2();
    mat2 linear = mat2(column, next2());
    float eta = next();
    float t = next();
    float alpha = next();
    at = gl_GlobalInvocationID.x * 57;
    SlopeMoments a = moments_of_distribution(m, S);
    SlopeMoments b = moments_of_normal(n);
    put(a);
    put(b);
    put(add_moments(a, b));
    put(scale_moments(a, eta));
    put(shear_moments(a, shear));
    put(map_moments(linear, a));
    put(mix_moments(a, b, t));
    put(roughen_moments(a, alpha));
    put(slope_of_heights(vec4(m, shear), abs(column) + 0.1));
    // Mean and variances are so large that they do not cancel. covariance_from_moments has its own probe.
    put(moments_covariance(SlopeMoments(0.1 * n.xy, S + 0.02)));
    put(moments_of_slope(shear).second.xy);
    put(moments_of_corner(vec4(m, shear), vec2(-0.2, 0.1) + vec2(-1.0, 1.0) * column * column));
    put(mask_moments(b, column));
}
