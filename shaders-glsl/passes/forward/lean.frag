#version 460
#extension GL_GOOGLE_include_directive : require
// Shades one light by LEAN mapping, which uses the density of the filtered slopes, and the cosine at the mean normal.
#include "slopes.glsl"

void main() {
    Point point = shaded_point();
    Slopes slopes = filtered_slopes(point);
    vec3 wi = sun_in(point.frame);
    vec3 wh = normalize(point.wo + wi);
    vec3 radiance = vec3(0.0);
    if (wh.z > 0.0) {
        vec3 fresnel = fresnel_schlick(vec3(forward.surface.x), dot(wi, wh));
        float cosine = max(dot(normal_of_slope(slopes.mean), wi), 0.0);
        radiance = forward.sun_irradiance.rgb * fresnel * (0.25 * beckmann_as_printed(wh, slopes) * cosine);
    }
    out_radiance = vec4(radiance, 1.0);
}
