#version 460
#extension GL_GOOGLE_include_directive : require
// Shades one light with a Blinn-Phong lobe about the normal of the mean slope.
#include "point.glsl"
#include "leadr/materials/classic.glsl"

void main() {
    Point point = shaded_point();
    vec3 n = normal_of_slope(texture(slope_map, in_texcoord).xy * point.scale);
    vec3 wi = sun_in(point.frame);
    vec3 wh = normalize(point.wo + wi);
    vec3 fresnel = fresnel_schlick(vec3(forward.surface.x), dot(wi, wh));
    float density = blinn_phong_ndf(dot(n, wh), blinn_phong_exponent(forward.material.w));
    out_radiance = vec4(forward.sun_irradiance.rgb * fresnel * (0.25 * density * max(dot(n, wi), 0.0)), 1.0);
}
