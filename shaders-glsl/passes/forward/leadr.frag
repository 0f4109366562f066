#version 460
#extension GL_GOOGLE_include_directive : require
// Shades one light by LEADR mapping with masking only (supplement, 3.2 and 3.3).
#include "slopes.glsl"
#include "leadr/masking/smith.glsl"

// Returns Lambda for a direction, within the limits of the supplement.
float lambda_as_printed(const vec3 w, const Slopes slopes) {
    vec3 S = slopes.covariance;
    vec2 azimuth = normalize(w.xy);
    float variance = azimuth.x * azimuth.x * S.x + azimuth.y * azimuth.y * S.y + 2.0 * azimuth.x * azimuth.y * S.z;
    float cotangent = w.z * inversesqrt(max(1.0 - w.z * w.z, 1e-6));
    return smith_lambda_fit(clamp((cotangent - dot(azimuth, slopes.mean)) * inversesqrt(2.0 * variance), 0.001, 1.599));
}

void main() {
    Point point = shaded_point();
    Slopes slopes = filtered_slopes(point);
    vec3 wi = sun_in(point.frame);
    vec3 wh = normalize(point.wo + wi);
    vec3 radiance = vec3(0.0);
    if (wh.z > 0.0) {
        vec3 fresnel = fresnel_schlick(vec3(forward.surface.x), dot(wi, wh));
        float area = max(dot(vec3(-slopes.mean, 1.0), point.wo), 1e-3);
        float visible = area * (1.0 + lambda_as_printed(point.wo, slopes));
        radiance = forward.sun_irradiance.rgb * fresnel * (0.25 * beckmann_as_printed(wh, slopes) / visible);
    }
    out_radiance = vec4(radiance, 1.0);
}
