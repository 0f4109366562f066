#ifndef LEADR_VISIBLE_MAPPED_GLSL
#define LEADR_VISIBLE_MAPPED_GLSL

#include "../masking/variants.glsl"
#include "../facets/beckmann.glsl"
#include "diffuse.glsl"
#include "fresnel.glsl"
#include "specular.glsl"

// Shades a normal map on smooth geometry (thesis 2.1, Table 2.IV). The map's facets occlude nothing, and are weighted by their fraction of
// the macrosurface. The slopes of the facets that face the viewer have a truncated normal density. Facets that face away are black, because
// <wo, wm> is clamped. The facets of the base are weighted by projected area (derivation in
// crates/leadr-reflectance/src/visible/mapped.rs). Once per pixel
//     MappedSlopes v = mapped_slopes(wo, m, S of the map, S with the base);
//     VisibleProbes probes = mapped_probes(wo, v, probe_kernel(n));
// and for each probe as in specular.glsl; multiply the sum by v.facing.

const float LEADR_LEAST_FACING_DEVIATION = 1e-4;

struct MappedSlopes {
    VisibleSlopes slopes; // slopes of the facets that face the viewer
    float facing;         // fraction of the facets that face the viewer
    float relief;         // fraction of the slope variance that comes from the map
};

// Returns the quotient of the normal density and its integral up to nu.
float lambda_at(const float nu) {
    return nu < 0.0 ? 1.0 / mills_ratio(-nu) : normal_pdf(nu) / normal_cdf(nu);
}

// Returns the fourth cumulant of a normal density truncated at nu.
float fourth_cumulant(float nu) {
    nu = clamp(nu, -4.0, 40.0);
    float lambda = lambda_at(nu);
    float first = -lambda * (nu + lambda);
    float second = -lambda - (nu + 2.0 * lambda) * first;
    return -2.0 * first * (1.0 + first) - (nu + 2.0 * lambda) * second;
}

// Returns the slopes of a map with covariance `relief`. The covariance `all` includes the slopes of the base as well.
MappedSlopes mapped_slopes(const vec3 wo, vec2 m, vec3 relief, const vec3 all) {
    vec3 R = clamp_covariance(relief);
    MappedSlopes mapped;
    VisibleSlopes v;
    v.S = clamp_covariance(all);
    vec3 B = clamp_covariance(v.S - R);
    // The map contributes these terms.
    vec2 across_r = vec2(R.x * wo.x + R.z * wo.y, R.z * wo.x + R.y * wo.y);
    float br = sqrt(max(dot(across_r, wo.xy), 0.0));
    mapped.facing = normal_cdf(meso_area(wo, m) / max(br, LEADR_LEAST_FACING_DEVIATION));
    v.a = tilted_area(wo, m, br);
    v.m = face_viewer(wo, m, R, 2.0 * LEADR_VISIBLE_TAIL);
    float per_r = 1.0 / max(br, 1e-18);
    float nu = min(v.a * per_r, 40.0);
    float cdf = normal_cdf(nu);
    float lambda = lambda_at(nu);
    float variance_r = clamp(1.0 - nu * lambda - lambda * lambda, 0.02, 1.0);
    float third_r = min(-lambda * (2.0 * lambda * lambda + 3.0 * nu * lambda + nu * nu - 1.0), 0.0);
    float facet_r = max(v.a + br * lambda, 1e-3);
    // The base contributes these terms on the mean facet.
    vec2 across_b = vec2(B.x * wo.x + B.z * wo.y, B.z * wo.x + B.y * wo.y);
    float bb = sqrt(max(dot(across_b, wo.xy), 0.0));
    float per_b = 1.0 / max(bb, 1e-18);
    float nu_b = facet_r * per_b;
    NormalRamp n = normal_ramp(nu_b);
    VisibleCumulants u_b = visible_cumulants(nu_b, n);
    float area_b = bb > 1e-18 ? bb * n.ramp : facet_r;
    // The cumulants of the map and of the base add.
    v.b = sqrt(br * br + bb * bb);
    float per = 1.0 / max(v.b, 1e-18);
    float part_r = br * per, part_b = bb * per;
    vec2 axis_r = across_r * per_r, axis_b = across_b * per_b;
    v.area = cdf * area_b;
    v.axis = (across_r + across_b) * per;
    v.shift = part_r * lambda + part_b * u_b.shift;
    v.mean = v.m - axis_r * lambda - axis_b * u_b.shift;
    v.cov = v.S - (1.0 - variance_r) * vec3(axis_r * axis_r, axis_r.x * axis_r.y)
                - (1.0 - u_b.variance) * vec3(axis_b * axis_b, axis_b.x * axis_b.y);
    v.facet = facet_r + bb * u_b.shift;
    v.variance = v.b > 1e-18 ? clamp(part_r * part_r * variance_r + part_b * part_b * u_b.variance, 0.02, 1.0) : 1.0;
    v.third = part_r * part_r * part_r * third_r + part_b * part_b * part_b * u_b.third;
    v.fourth = part_r * part_r * part_r * part_r * fourth_cumulant(nu) + part_b * part_b * part_b * part_b * u_b.fourth;
    mapped.slopes = v;
    mapped.relief = clamp((R.x + R.y) / max(v.S.x + v.S.y, 1e-18), 0.0, 1.0);
    return mapped;
}

// Returns the probes of a normal map and its base. Away from the mean, kernels also grow with the projected area of the facet, because this
// area does not cancel on a normal map.
VisibleProbes mapped_probes(const vec3 wo, const MappedSlopes v, const vec3 kernel) {
    VisibleProbes probes = visible_probes_of(LEADR_SHADOWING_NONE, wo, v.slopes, kernel);
    probes.projected = vec2(v.relief, 1.0 / max(v.slopes.facet, 1e-9));
    return probes;
}

// Returns the mean Fresnel reflectance of all facets. Facets that face away have a cosine of 0.
vec3 mapped_fresnel(const MappedSlopes v, const vec3 f0) {
    return f0 + (grazing_reflectance(f0) - f0) * (1.0 + v.facing * (visible_schlick_weight(v.slopes) - 1.0));
}

// Returns the mean of the exact reflectance (fresnel_exact) of all facets.
vec3 mapped_fresnel_exact(const MappedSlopes v, const vec3 f0, const ComplexIndex index) {
    return clamp(mapped_fresnel(v, f0) + v.facing * mean_deviation(visible_cosines(v.slopes), f0, index), 0.0, 1.0);
}

// Returns the moments of all normals; visible_diffuse_moments gives the moments of the visible ones.
NormalMoments mapped_diffuse_moments(const vec2 m, vec3 S, const int terms) {
    S = clamp_covariance(S);
    vec2 spread = squared_normal_spread(m, S);
    vec3 first = vec3(0.0), diag = vec3(0.0), off = vec3(0.0);
    for (int i = 0; i < terms; ++i) {
        vec4 e = visible_diffuse_exponent(i, terms);
        vec2 second = visible_diffuse_second(i, terms);
        SlopeGaussian g = damped_gaussian(m, S, (e.x + e.y * spread.y) / spread.x);
        float c = g.weight * (e.z + e.w * spread.y);
        float d = g.weight * (second.x + second.y * spread.y);
        first += c * vec3(-g.m, 1.0);
        diag += d * vec3(g.m * g.m + g.S.xy, 1.0);
        off += d * vec3(-g.m.yx, g.m.x * g.m.y + g.S.z);
    }
    float scale = 1.0 / max(diag.x + diag.y + diag.z, 1e-30);
    return NormalMoments(first * inversesqrt(spread.x), diag * scale, off * scale);
}

// Returns the mean clamped cosine over all facets, for one light from wi (tangent frame). The light's irradiance on a plane facing it is 1,
// and the albedo is 1.
float mapped_diffuse_light(const vec3 wi, const vec2 m, vec3 S, const int terms) {
    S = clamp_covariance(S);
    vec2 spread = squared_normal_spread(m, S);
    float sum = 0.0;
    for (int i = 0; i < terms; ++i) {
        vec4 e = visible_diffuse_exponent(i, terms);
        SlopeGaussian g = damped_gaussian(m, S, (e.x + e.y * spread.y) / spread.x);
        sum += g.weight * (e.z + e.w * spread.y) * clamped_mean(meso_area(wi, g.m), slope_spread(wi, g.S));
    }
    return sum * inversesqrt(spread.x) / LEADR_PI;
}

// Returns the specular response to a light, for mean slope m and covariance S, per unit of irradiance on a plane that faces the light. The
// response is F D / (4 f), with f the projected area of the reflecting facet (thesis Table 2.IV). The base is treated as a part of the map.
vec3 mapped_specular_light(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const vec3 f0) {
    vec3 h = wo + wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float facet = max(half_facet_area(wo, wi, wh), LEADR_MIN_AREA);
    return fresnel_schlick(f0, dot(wi, wh)) * (0.25 * beckmann_ndf_over(wh, m, S, facet));
}

#endif
