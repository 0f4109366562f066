// Shadowing by the relief around a pixel: leadr/visible/horizon.glsl for techniques that support it, or the cone of its
// material, which all techniques use (leadr/masking/occlusion.glsl).
#ifndef LEADR_SHADE_RELIEF
#define LEADR_SHADE_RELIEF
#include "surface.glsl"
#include "settings.glsl"
#include "leadr/integrals/sh.glsl"
#include "leadr/masking/occlusion.glsl"
#include "leadr/visible/cone_specular.glsl"

bool has_cone(const Surface surface) {
    return CONES && surface.cone.w >= 0.0;
}

// Fraction of the light about wi (tangent frame) that passes the surrounding relief. deviation: of the light, radians.
float relief_visibility(const Surface surface, const vec3 wi, const float deviation) {
    if (has_cone(surface)) {
        return cone_light_smooth(cone_of_vector(surface.cone.xyz), wi);
    }
    return USES_HORIZON ? horizon_visibility(wi, surface.mean_slope, surface.horizon, deviation) : 1.0;
}

// Factor of a cone on the environment's diffuse light, for a surface of this albedo: the visible share of the surroundings,
// with hidden directions as bright as the surface itself (Chan 2018, eq. 49), times the brightness about the axis of the cone
// relative to that about the normal.
vec3 cone_diffuse(const Surface surface, const vec3 albedo, const vec3 c[9]) {
    if (!has_cone(surface)) {
        return vec3(1.0);
    }
    vec3 axis = cone_of_vector(surface.cone.xyz).xyz;
    vec3 about = max(sh_irradiance(c, from_frame(surface.frame, axis)), 0.0);
    vec3 whole = max(sh_irradiance(c, from_frame(surface.frame, normal_of_slope(surface.mean_slope))), 1e-4);
    return interreflected_visibility(surface.cone.w, albedo) * min(about / whole, 2.0);
}

// Fraction of the environment's specular light, of GGX roughness alpha about the mean normal, that a cone leaves.
float cone_specular_share(const Surface surface, const float alpha) {
    if (!has_cone(surface)) {
        return 1.0;
    }
    Frame about = frame_about(normal_of_slope(surface.mean_slope));
    vec4 cone = cone_of_vector(surface.cone.xyz);
    return cone_specular(alpha, to_frame(about, surface.wo), vec4(to_frame(about, cone.xyz), cone.w));
}

#endif
