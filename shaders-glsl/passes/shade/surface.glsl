// The surface from which a pixel is shaded.
#ifndef LEADR_SHADE_SURFACE
#define LEADR_SHADE_SURFACE
#include "../bases.glsl"
#include "../gbuffer.glsl"
#include "../technique.glsl"
#include "fits.glsl"
#include "leadr/facets/complex_index.glsl"
#include "leadr/masking/classes.glsl"

layout(constant_id = 33) const int FRESNEL = 0; // form of the Fresnel term: Schlick's, or exact
const bool EXACT_FRESNEL = FRESNEL == 1;

struct Surface {
    uvec2 pixel;
    vec3 position;       // position in world space
    Frame frame;         // tangent frame, whose z is the displacement direction
    vec3 wo;             // direction toward the viewer, in the tangent frame
    vec2 mean_slope;
    vec3 slope_covariance;
    vec3 albedo;
    float alpha;
    uint fit;            // start of the measured base material, or 0
    vec3 f0;             // reflectance at normal incidence
    vec3 diffuse_f0;     // reflectance of the diffuse base's surface; the metallic fraction has no albedo
    vec3 edge_tint;      // F82 tint of a conductor's reflectance
    ComplexIndex index;  // with EXACT_FRESNEL, of f0 and of diffuse_f0
    ComplexIndex diffuse_index;
    vec3 emission;       // emitted radiance, before scaling
    float accessibility;
    bool inside;
    float relief;        // relief of an edge sample's object, in metres
    float sunlit;        // fraction of the joined edge samples lit by the first sun
    vec4 more_sunlit;    // the same fraction for each of the other suns
    float joined;        // weight of `sunlit`, 0 to 1
    Horizon horizon;     // horizon of the relief
    Coat coat;           // clear coat, with COATED
    vec3 coat_normal;    // normal about which the coat's own relief is given, in world space
    uint medium;         // number of the medium behind the surface, with TRANSMITS, or 0
    bool under_coat;     // whether the light that this surface reflects passes its coat
    bool above;          // whether this is a coat with its own relief, which the relief below does not occlude
    vec4 sky;            // fraction of the environment that large shapes leave visible (sky_seen)
    vec4 cone;           // replaces the horizon with CONES; w < 0 without a cone
    vec3 relief_radiance; // with INTERREFLECTION, radiance of the relief in blocked directions
    float larger;         // with INTERREFLECTION, fraction of the hemisphere that bumps larger than the footprint hide
    vec2 whitened;       // direction of the viewer in the space where the relief is isotropic
    vec2 whole_mean;     // mean slope of all classes
    vec3 whole_cholesky; // Cholesky factor of the covariance of all classes
    vec4 sky_light;      // with BY_CLASS, pixel_sky of the shaded class
    vec3 sharp;          // with PER_LIGHT_KERNEL, slope_covariance without the pixel kernel
};

// The classes of facets of the pixel, with CLASSES > 1. Drivers copy values of type Surface, which has none of these arrays.
FacetClasses pixel_classes;
mat2 pixel_rotation; // with PER_LIGHT_KERNEL, the changes of the normal to the next pixels

// Whether the base is a measured material. At the finest level, this excludes normal-map facets that face away.
bool is_fitted(const uint fit) {
    return FIT_LOBES > 0 && (ALL_FITTED && !FINEST_LEVEL || fit > 0u);
}

vec3 fresnel_of(const Surface s, const float cosine) {
    if (is_fitted(s.fit)) {
        return fitted_fresnel(s.fit, cosine);
    }
    return EXACT_FRESNEL ? fresnel_exact(s.f0, s.index, cosine) : fresnel_edge_tint(s.f0, s.edge_tint, cosine);
}

// Returns the Fresnel term of the surface of the diffuse base.
vec3 diffuse_fresnel_of(const Surface s, const float cosine) {
    return EXACT_FRESNEL ? fresnel_exact(s.diffuse_f0, s.diffuse_index, cosine) : fresnel_schlick(s.diffuse_f0, cosine);
}

// Sets the values that follow from the reflectances.
void set_index(inout Surface s) {
    if (EXACT_FRESNEL) {
        s.index = complex_index(s.f0, s.edge_tint);
        s.diffuse_index = complex_index(s.diffuse_f0, vec3(0.0));
    }
}

// Returns the Fresnel term divided by its Schlick form. The quotient is due to the F82 tint or the exact form. For a measured material, whose
// f0 is 1, it is the whole Fresnel term.
vec3 fresnel_over_schlick(const uint fit, const vec3 f0, const vec3 edge_tint, const ComplexIndex index, const float cosine) {
    if (is_fitted(fit)) {
        return fitted_fresnel(fit, cosine);
    }
    if (EXACT_FRESNEL) {
        return fresnel_exact(f0, index, cosine) / max(fresnel_schlick(f0, cosine), 1e-6);
    }
    return 1.0 - edge_tint * (edge_tint_weight(cosine) / max(fresnel_schlick(f0, cosine), 1e-6));
}

// Returns the surface at a pixel. ray passes through the pixel, scaled so that the surface lies at ray * near / depth (reversed depth). The
// result excludes joined edge samples.
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
    s.f0 = f.f0;
    s.diffuse_f0 = vec3(f.diffuse_f0);
    s.edge_tint = f.edge_tint;
    s.fit = 0u;
    if (is_fitted(f.fit)) {
        // The material's own table of reflectances multiplies the specular term. The diffuse base is the measured diffuse part.
        s.fit = fit_at(f.fit);
        s.f0 = vec3(1.0);
        s.diffuse_f0 = vec3(0.0);
        s.edge_tint = vec3(0.0);
    }
    set_index(s);
    s.emission = f.emission;
    s.accessibility = f.accessibility;
    s.inside = f.inside;
    s.relief = f.relief;
    s.sunlit = 0.0;
    s.more_sunlit = vec4(0.0);
    s.joined = 0.0;
    s.horizon = f.horizon;
    s.cone = f.cone;
    s.coat = f.coat;
    s.coat_normal = f.normal;
    s.medium = f.medium;
    s.under_coat = false;
    s.above = false;
    if (CLASSES > 1) {
        pixel_classes = f.classes;
    }
    if (PER_LIGHT_KERNEL) {
        pixel_rotation = f.rotation;
    }
    s.sky = vec4(0.0, 0.0, 0.0, 1.0);
    return s;
}

#endif
