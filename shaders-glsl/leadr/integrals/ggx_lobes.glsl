#ifndef LEADR_GGX_LOBES_GLSL
#define LEADR_GGX_LOBES_GLSL

#include "../masking/correlated.glsl"
#include "../facets/fresnel.glsl"
#include "ggx_filtering.glsl"

// Shades a displaced GGX surface under lights and environments. GGX is an integral of Gaussians, so under an environment a mixture of a few
// Gaussian surfaces replaces it (crates/leadr-reflectance/src/integrals/ggx_lobes.rs).

struct GaussianLobe {
    float weight; // fraction of the slopes in this lobe; the weights of all lobes sum to one
    vec3 S;       // covariance of the lobe's slopes
};

const int LEADR_GGX_LOBES = 4;

// Returns one Gaussian lobe of d: for k = 0 the Beckmann lobe, otherwise one of the three lobes that represent the GGX lobe.
GaussianLobe ggx_lobe(const DisplacedGgx d, const int k) {
    const vec2 lobes[4] = vec2[4](vec2(0.0, 1.0), vec2(0.3424, 2.069), vec2(0.4764, 0.5126), vec2(0.1812, 0.0825));
    vec2 lobe = lobes[k]; // fraction of the GGX lobe, and ratio of the variance to Beckmann's
    return GaussianLobe(k == 0 ? 1.0 - d.weight : d.weight * lobe.x, d.roughness * (0.5 / lobe.y));
}

// Returns the visible area of the surface along w. cholesky is the Cholesky factor of roughness / 2.
DirectionArea displaced_ggx_area(const vec3 w, const vec2 m, const DisplacedGgx d, const vec3 cholesky) {
    vec2 whitened = whitened_direction(w, cholesky);
    float meso = meso_area(w, m);
    return DirectionArea(whitened, length(whitened), meso, max(meso, 0.0) + displaced_rough_area(w, meso, d));
}

// Returns the radiance towards wo under one light from wi, per unit of irradiance on a plane that faces the light. o is the result of
// displaced_ggx_area for wo.
vec3 displaced_ggx_light(const int shadowing, const DirectionArea o, const vec3 wo, const vec3 wi, const vec2 m, const DisplacedGgx d,
                         const vec3 cholesky,
                         const vec3 f0) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float lit = masking_shadowing_factor(shadowing, o, displaced_ggx_area(wi, m, d, cholesky));
    return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * displaced_ggx_ndf(wh, m, d) * lit);
}

#endif
