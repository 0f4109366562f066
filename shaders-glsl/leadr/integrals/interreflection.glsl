#ifndef LEADR_INTERREFLECTION_GLSL
#define LEADR_INTERREFLECTION_GLSL

#include "../masking/class_sky.glsl"

// Computes light that the facets of a relief send to each other (crates/leadr-reflectance/src/integrals/interreflection.rs). All blocked
// directions see the same mean radiosity. Once per pixel:
//     ReliefBounces bounces = relief_bounces(sky, albedo);
// and for each light, with its irradiance E on the mesosurface without shadows (the light's irradiance times the clamped cosine between its
// direction and the normal of the mean slope), and the shares of the classes in its flux (the visible shares towards it):
//     vec3 B = relief_radiosity(bounces, E, shares);    // for the sky: sky.flux
// The visible facets of class k then reflect albedo[k] * (1 - seen[k]) * B / pi (ClassEnvironment.seen). Specular reflections in blocked
// directions see the radiance B / pi.

struct ReliefBounces {
    mat4x3 weight; // column k: mean radiosity in blocked directions per unit of flux that class k receives
};

// Returns the response of classes of these albedos, 0..1. The albedo is the whole reflectance of the facets for diffuse light: for a metal,
// the mean of its Fresnel reflectance.
ReliefBounces relief_bounces(const ClassSky sky, const vec3 albedo[4]) {
    vec3 under = vec3(0.0);
    ReliefBounces bounces;
    for (int k = 0; k < 4; ++k) {
        vec3 reflected = sky.blocked[k] * albedo[k];
        under += (sky.area[k] * sky.blocked[k]) * (1.0 - reflected);
        bounces.weight[k] = reflected;
    }
    vec3 per = under / (under * under + 1e-10); // flat facets see no radiosity, which would be a quotient of rounding errors
    for (int k = 0; k < 4; ++k) bounces.weight[k] *= per;
    return bounces;
}

// Returns the radiosity that the facets see in blocked directions. shares are the shares of the classes in the light's flux.
vec3 relief_radiosity(const ReliefBounces bounces, const vec3 irradiance, const vec4 shares) {
    return irradiance * (bounces.weight * shares);
}

#endif
