// Shadowing by the relief around a pixel. Techniques that support it use leadr/visible/horizon.glsl. All techniques use the cone of a
// material, if there is one (leadr/masking/occlusion.glsl).
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

// Returns the fraction of the light about wi (tangent frame) that passes the surrounding relief. deviation is the standard deviation of the
// light, in radians.
float relief_visibility(const Surface surface, const vec3 wi, const float deviation) {
    if (has_cone(surface)) {
        vec4 cone = CONE_AXIS == LEADR_CONE_AXIS_NORMAL ? vec4(normal_of_slope(surface.mean_slope), cone_cosine(surface.cone.w))
                                                        : cone_of_vector(surface.cone.xyz);
        return cone_light_by_edge(CONE_EDGE, cone, wi);
    }
    float seen = USES_HORIZON ? horizon_visibility(wi, surface.mean_slope, surface.horizon, deviation) : 1.0;
    // Classes in a footprint can face a light that is below the plane of their mean slope.
    return BY_CLASS ? mix(seen, 1.0, pixel_classes.inside) : seen;
}

// Returns the factor of a cone on the environment's diffuse light, for a surface of this albedo. The factor is the visible fraction of the
// surroundings, with the light of hidden directions by CONE_OCCLUDERS (Chan 2018, eq. 45-49). The visible fraction is multiplied by the
// ratio of the brightness about the cone's axis to the brightness about the normal.
vec3 cone_diffuse(const Surface surface, const vec3 albedo, const vec3 c[9]) {
    if (!has_cone(surface)) {
        return vec3(1.0);
    }
    vec3 axis = cone_of_vector(surface.cone.xyz).xyz;
    vec3 about = max(sh_irradiance(c, from_frame(surface.frame, axis)), 0.0);
    vec3 whole = max(sh_irradiance(c, from_frame(surface.frame, normal_of_slope(surface.mean_slope))), 1e-4);
    return adjusted_visibility(CONE_OCCLUDERS, surface.cone.w, albedo) * min(about / whole, 2.0);
}

// Returns the fraction of the environment's specular light that a cone lets through, for GGX roughness alpha about the mean normal.
float cone_specular_share(const Surface surface, const float alpha) {
    if (!has_cone(surface)) {
        return 1.0;
    }
    Frame about = frame_about(normal_of_slope(surface.mean_slope));
    vec4 cone = cone_of_vector(surface.cone.xyz);
    vec3 wo = to_frame(about, surface.wo);
    cone = vec4(to_frame(about, cone.xyz), cone.w);
    return cone_specular(alpha, wo, cone_of_lobe(CONE_LOBE, cone, surface.cone.w, alpha_gloss(alpha, LEADR_GLOSS_WWII), wo.z));
}

#endif
