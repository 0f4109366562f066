// Light that passes through a surface (leadr/visible/transmission.glsl). Included by leadr.glsl. The light comes from the environment, suns
// and lamps; other objects behind the surface are not seen through it.
#ifndef LEADR_SHADE_TRANSMISSION
#define LEADR_SHADE_TRANSMISSION
#include "leadr/visible/transmission.glsl"

// Two vectors for each medium of the scene (crates/leadr-render/src/surfaces/media.rs).
layout(set = 1, std430) readonly buffer Media { vec4 media[]; };

struct Medium {
    float weight;     // fraction of the light below the specular term that passes, instead of scattering in the diffuse base
    float eta;        // refractive index
    float thickness;  // metres through the middle of the body, or 0 for a thin wall
    vec3 extinction;  // per metre
};

const Medium NO_MEDIUM = Medium(0.0, 1.5, 0.0, vec3(0.0));

// Returns the medium with this number, counted from 1, or no medium for 0.
Medium medium_of(const uint number) {
    if (number == 0u) {
        return NO_MEDIUM;
    }
    vec4 first = media[2u * number - 2u];
    return Medium(first.x, first.y, first.z, media[2u * number - 1u].rgb);
}

// Returns the radiance behind the surface from direction d of the tangent frame, with light of this variance per axis. Suns and lamps shine
// with the density of a von Mises-Fisher lobe.
vec3 radiance_behind(const Surface surface, const vec3 d, const float variance) {
    vec3 sum = SPECULAR_ENVIRONMENT ? lobe_radiance(surface, d, min(variance, 1.0)) : vec3(0.0);
    [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
        if (in_specular(number)) {
            Light light = light_sent(number, surface);
            float kappa = 1.0 / max(variance + light.variance, 1e-5);
            sum += light.irradiance * (kappa / (2.0 * LEADR_PI * (1.0 - exp(-2.0 * kappa))) * exp(kappa * (dot(d, light.wi) - 1.0)));
        }
    }
    return sum;
}

// Returns the light that passes one facet of a solid body. `variance` is that of the facets of both sides that the facet stands for.
vec3 passed_facet(const Surface surface, const Medium medium, const vec3 facet, const float variance) {
    vec3 n = vec3(0.0, 0.0, 1.0);
    return radiance_behind(surface, passed_solid(surface.wo, facet, n, medium.eta),
                           refracted_variance(variance, max(surface.wo.z, 0.0), medium.eta));
}

// Returns the mean light that passes the visible facets, without the light that they reflect. The specular term has the same facets.
vec3 transmitted(const Surface surface, const Medium medium, const Base base, const vec3 entering) {
    vec3 wo = surface.wo;
    if (medium.thickness <= 0.0) {
        return entering * radiance_behind(surface, -wo, thin_variance(surface.alpha, max(wo.z, 0.0)));
    }
    vec3 sum = vec3(0.0);
    float far_side = 0.5 * (base.S.x + base.S.y), all = 0.0;
    if (DRAWN_SPECULAR) {
        DirectionArea o = direction_area(wo, surface.mean_slope, slope_cholesky(base.S));
        uint seed = draw_seed(surface.pixel, lighting.draws.y, 0u);
        for (int i = 0; i < SAMPLES; ++i) {
            vec2 u = drawn_point(lighting.draws.x * uint(SAMPLES) + uint(i), seed);
            DrawnReflection d = drawn_reflection(wo, u, surface.mean_slope, base.S, o.visible);
            float passed = 1.0 - diffuse_fresnel_of(surface, d.cosine).x;
            sum += passed * passed_facet(surface, medium, normalize(wo + d.wi), far_side);
            all += passed;
        }
    } else {
        const int count = VISIBLE_SLOPES ? SAMPLES : 16;
        vec3 kernel = probe_kernel(count);
        VisibleProbes probes;
        if (MAPPED) {
            probes = mapped_probes(wo, mapped_slopes(wo, surface.mean_slope, surface.slope_covariance, base.S), kernel);
        } else {
            probes = visible_probes(LEADR_SHADOWING_NONE, wo, surface.mean_slope, base.S, kernel);
        }
        [[unroll]] for (int i = 0; i < count; ++i) {
            VisibleProbe p = visible_probe(probes, wo, probe_node(count, i, probes.wide));
            float passed = p.weight * (1.0 - diffuse_fresnel_of(surface, p.cosine).x);
            // Reflected directions turn by twice the angle of their facet.
            sum += passed * passed_facet(surface, medium, normal_of_slope(p.slope), p.variance / max(4.0 * p.cosine, 0.1) + far_side);
            all += passed;
        }
    }
    vec3 kept = attenuation(medium.extinction, medium.thickness * refracted_cosine(max(wo.z, 0.0), medium.eta));
    return entering * kept * sum / max(all, 1e-6);
}

#endif
