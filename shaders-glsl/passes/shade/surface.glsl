// The surface that a pixel is shaded from.
#ifndef LEADR_SHADE_SURFACE
#define LEADR_SHADE_SURFACE
#include "../bases.glsl"
#include "../gbuffer.glsl"
#include "../technique.glsl"
#include "fits.glsl"
#include "leadr/facets/fresnel.glsl"

struct Surface {
    uvec2 pixel;
    vec3 position;       // world
    Frame frame;         // tangent frame, z the displacement direction
    vec3 wo;             // tangent frame, toward the viewer
    vec2 mean_slope;
    vec3 slope_covariance;
    vec3 albedo;
    float alpha;
    MixedRoughness mixed; // the two that alpha stands for, where MIXED_ROUGHNESS says so
    uint fit;            // where the measured material begins that its base is, or 0
    vec3 f0;             // reflectance at normal incidence
    vec3 body_f0;        // of the part that has albedo: metal beside it has none
    vec3 dip;            // of a conductor's reflectance
    vec3 emission;       // radiance, to be scaled
    ReliefColor relief_color; // how albedo follows the relief
    float accessibility;
    bool inside;
    float relief;        // of the object of an edge sample, metres
    float sunlit;        // fraction of the joined edge samples that the first sun reaches
    vec4 more_sunlit;    // and the others
    float joined;        // weight of `sunlit`, 0 to 1
    Horizon horizon;     // of its relief
    vec4 sky;            // what large shapes leave of the surroundings, see sky_seen
    vec4 cone;           // in its place, where CONES says so; w below 0 without one
};

// Whether the base is a measured material. Facets of normal maps that face away lose theirs, on the finest level.
bool is_fitted(const uint fit) {
    return FIT_LOBES > 0 && (ALL_FITTED && !FINEST_LEVEL || fit > 0u);
}

vec3 fresnel_of(const Surface s, const float cosine) {
    if (is_fitted(s.fit)) {
        return fitted_fresnel(s.fit, cosine);
    }
    return fresnel_dipped(s.f0, s.dip, cosine);
}

// The Fresnel term over its Schlick form: what a dip leaves of it, or all of a measured one, whose f0 is 1.
vec3 fresnel_over_schlick(const uint fit, const vec3 f0, const vec3 dip, const float cosine) {
    if (is_fitted(fit)) {
        return fitted_fresnel(fit, cosine);
    }
    return 1.0 - dip * (dip_weight(cosine) / max(fresnel_schlick(f0, cosine), 1e-6));
}

// ray: through the pixel, scaled so that the surface lies at ray * near / depth (reversed). Without joined edge samples.
Surface surface_at(const FilteredSurface f, const vec3 eye, const vec3 ray, const float near, const float depth) {
    Surface s;
    s.pixel = uvec2(0u);
    s.position = eye + ray * (near / depth);
    s.frame = frame_about(f.normal);
    s.wo = to_frame(s.frame, -normalize(ray));
    s.mean_slope = f.mean_slope;
    s.slope_covariance = f.covariance;
    s.albedo = f.material.rgb;
    s.alpha = f.material.a;
    s.mixed = f.mixed;
    s.f0 = f.f0;
    s.body_f0 = vec3(f.body_f0);
    s.dip = f.dip;
    s.fit = 0u;
    if (is_fitted(f.fit)) {
        // Its own table of reflectances multiplies all that it mirrors, and its body is what was measured beside that.
        s.fit = fit_at(f.fit);
        s.f0 = vec3(1.0);
        s.body_f0 = vec3(0.0);
        s.dip = vec3(0.0);
    }
    s.emission = f.emission;
    s.relief_color = f.relief_color;
    s.accessibility = f.accessibility;
    s.inside = f.inside;
    s.relief = f.relief;
    s.sunlit = 0.0;
    s.more_sunlit = vec4(0.0);
    s.joined = 0.0;
    s.horizon = f.horizon;
    s.cone = f.cone;
    s.sky = vec4(0.0, 0.0, 0.0, 1.0);
    return s;
}

#endif
