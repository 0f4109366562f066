// LEADR: integrals over the visible slopes. Specular lights by eq. 17; specular environment by eq. 19 and 22, on the
// paper's grid (Algorithm 1) or a few probes; diffuse by eq. 20-23 (Algorithms 2 and 3), on the grid or in closed
// form, or by one lookup for environments with shadows.
#ifndef LEADR_SHADE_LEADR
#define LEADR_SHADE_LEADR
#include "draws.glsl"
#include "fitted_facets.glsl"
#include "bounces.glsl"
#include "harmonics.glsl"
#include "lighting.glsl"
#include "leadr/facets/base_roughness.glsl"
#include "leadr/integrals/diffuse.glsl"
#include "leadr/integrals/facet_mirrors.glsl"
#include "leadr/integrals/ggx_lobes.glsl"
#include "leadr/integrals/light_size.glsl"
#include "leadr/visible/shadowed_environment.glsl"
#include "leadr/visible/shadowed_specular.glsl"
#include "leadr/integrals/specular.glsl"
#include "leadr/materials/classic.glsl"
#include "leadr/visible/diffuse.glsl"
#include "leadr/visible/fresnel.glsl"
#include "leadr/visible/mapped.glsl"
#include "leadr/visible/relief_color.glsl"
#include "leadr/visible/specular.glsl"

const float GRID_DEVIATION = 0.05; // of the light of one sample of the grid, as far as the relief's horizon is concerned
const int DIFFUSE_TERMS = 2; // of the closed form: see visible_diffuse.glsl
const bool FACET_MIRRORS = FACET_FRAME && !FINEST_LEVEL && !GGX_BASE; // of the lights

// Means over the visible mirrors.
struct Mirrors {
    vec3 reflected; // radiance, Fresnel and shadowing included
    vec3 fresnel;   // of the body, whose light it keeps from entering
    float area;     // visible area in arbitrary units: the weight among several sets of mirrors
};

// The mirrors of a normal map from those that face the viewer. The others are black, and reflect as at grazing incidence.
Mirrors of_facing(const Mirrors mirrors, const Surface surface, const float facing) {
    vec3 grazing = grazing_reflectance(surface.body_f0);
    return Mirrors(facing * mirrors.reflected, mix(grazing, mirrors.fresnel, facing), 1.0);
}

// One node of the grid; sums weights in `area`. relief: share of a normal map in the variance of the mirrors, whose facets count alike.
void add_grid_mirror(inout Mirrors sum, const vec3 node, const Surface surface, const vec3 wo, const vec2 m, const vec3 S,
                     const vec3 cholesky, const DirectionArea o, const float base, const float relief) {
    EnvironmentSample e = environment_sample_at(wo, slope_at(node.xy, m, cholesky));
    float weight = node.z * e.area;
    if (MAPPED) {
        weight = node.z * mix(e.area, e.area > 0.0 ? max(o.meso, 1e-3) : 0.0, relief);
    }
    float cosine = dot(wo, e.wn);
    vec3 f = weight * fresnel_of(surface, cosine);
    float lit = lit_fraction(SHADOWING, o, area_for(SHADOWING, e.wi, m, S, cholesky))
              * relief_visibility(surface, e.wi, GRID_DEVIATION);
    sum.reflected += f * lit * environment_radiance(surface, e.wi, env_lod_at(base, wo, e.wn));
    sum.fresnel += weight * fresnel_schlick(surface.body_f0, cosine);
    sum.area += weight;
}

// Grids up to this many samples along a side are written out, which makes them a sixth faster (docs/measurements/performance.md).
const int WRITTEN_OUT = 5;

// Algorithm 1, with everything that is the same for all samples moved out of the loop.
Mirrors grid_mirrors(Surface surface, vec3 wo, vec3 S) {
    float lambda = grid_lambda(SAMPLES);
    vec2 m = face_viewer(wo, surface.mean_slope, S, lambda);
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = area_for(SHADOWING, wo, m, S, cholesky);
    float base = env_lod_base(S, grid_spacing(SAMPLES, lambda), lighting.environment.x, LEADR_LOD_MATCHED);
    Mirrors sum = Mirrors(vec3(0.0), vec3(0.0), 0.0);
    MappedSlopes mapped;
    if (MAPPED) {
        mapped = mapped_slopes(wo, surface.mean_slope, surface.slope_covariance, S);
    }
    float relief = MAPPED ? mapped.relief : 0.0;
    if (SAMPLES <= WRITTEN_OUT) {
        [[unroll]] for (int i = 0; i < min(SAMPLES, WRITTEN_OUT) * min(SAMPLES, WRITTEN_OUT); ++i) {
            add_grid_mirror(sum, grid_node(i / SAMPLES, i % SAMPLES, SAMPLES, lambda), surface, wo, m, S, cholesky, o, base, relief);
        }
    } else {
        for (int j = 0; j < SAMPLES; ++j) {
            for (int k = 0; k < SAMPLES; ++k) {
                add_grid_mirror(sum, grid_node(j, k, SAMPLES, lambda), surface, wo, m, S, cholesky, o, base, relief);
            }
        }
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    Mirrors mean = Mirrors(sum.reflected * scale, sum.fresnel * scale, o.visible);
    return MAPPED ? of_facing(mean, surface, mapped.facing) : mean;
}

// Probes of each of three lobes or more (docs/measurements/fitting.md has what they err by).
const int PROBES_OF_LOBE = 5;

// Where the probes of a lobe lie, and what is seen of it.
struct ProbedLobe {
    VisibleProbes probes;
    DirectionArea o;
    float facing; // share of the facets of a normal map that face the viewer
};

// kernel: of its rule.
ProbedLobe probed_lobe(const Surface surface, const vec3 wo, const vec3 S, const vec3 kernel) {
    ProbedLobe lobe;
    lobe.facing = 1.0;
    if (MAPPED) {
        MappedSlopes mapped = mapped_slopes(wo, surface.mean_slope, surface.slope_covariance, S);
        lobe.probes = mapped_probes(wo, mapped, kernel);
        lobe.facing = mapped.facing;
    } else {
        lobe.probes = visible_probes(SHADOWING, wo, surface.mean_slope, S, kernel);
    }
    lobe.o = direction_area(wo, lobe.probes.m, lobe.probes.cholesky);
    return lobe;
}

// What probes see. Their weights sum to one.
struct ProbeSums {
    vec3 at_normal;  // as if they reflected all of it
    vec3 by_angle;   // the same times Schlick's term, or, under a table of reflectances, times the cosine
    float lit;
    float grazing;   // Schlick's term
    float cosine;
    float cosine2;
};

// fitted: whether a table of reflectances multiplies what they see.
void add_probe(inout ProbeSums sums, const Surface surface, const vec3 wo, const ProbedLobe lobe, const ProbeNode node, const bool fitted) {
    VisibleProbe p = visible_probe(lobe.probes, wo, node);
    float mean_f0 = dot(surface.f0, vec3(1.0 / 3.0));
    LitProbe l = lit_probe(MAPPED ? LEADR_SHADOWING_NONE : SHADOWING, lobe.probes, lobe.o, wo, mean_f0, p, USES_HORIZON, surface.horizon);
    vec3 radiance = p.weight * lobe_radiance(surface, l.wi, l.narrowing * p.variance);
    sums.at_normal += l.lit * radiance;
    sums.by_angle += (fitted ? l.lit * p.cosine : l.grazing) * radiance;
    sums.lit += p.weight * l.lit;
    sums.grazing += p.weight * schlick_weight(p.cosine);
    sums.cosine += p.weight * p.cosine;
    sums.cosine2 += p.weight * p.cosine * p.cosine;
}

// The mirrors that probes stand for.
Mirrors probes_mirrors(const ProbeSums sums, const Surface surface, const ProbedLobe lobe, const bool fitted) {
    vec3 reflected;
    if (fitted) {
        // The table is nearly straight over a lobe: a line through it at a deviation of the cosines on either side.
        float spread = max(sqrt(max(sums.cosine2 - sums.cosine * sums.cosine, 0.0)), 1e-3);
        float high = min(sums.cosine + spread, 1.0), low = max(high - 2.0 * spread, 0.0);
        vec3 at_low = fitted_fresnel(surface.fit, low), slope = (fitted_fresnel(surface.fit, high) - at_low) / (high - low);
        reflected = max((at_low - low * slope) * sums.at_normal + slope * sums.by_angle, 0.0);
    } else {
        // A dip is wide: that of the mean mirror is the mean of theirs.
        vec3 rise = grazing_reflectance(surface.f0) - surface.f0;
        reflected = (surface.f0 - surface.dip * dip_weight(sums.cosine)) * sums.at_normal + rise * sums.by_angle;
    }
    vec3 body_f0 = surface.body_f0;
    vec3 fresnel = body_f0 + (grazing_reflectance(body_f0) - body_f0) * sums.grazing;
    Mirrors mean = Mirrors(reflected / max(sums.lit, 1.0), fresnel, lobe.probes.area);
    return MAPPED ? of_facing(mean, surface, lobe.facing) : mean;
}

// A few probes among the visible slopes, `count` of them.
Mirrors probe_mirrors(Surface surface, vec3 wo, const vec3 S, int count) {
    ProbedLobe lobe = probed_lobe(surface, wo, S, probe_kernel(count));
    bool fitted = is_fitted(surface.fit);
    ProbeSums sums = ProbeSums(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0);
    [[unroll]] for (int i = 0; i < count; ++i) {
        add_probe(sums, surface, wo, lobe, probe_node(count, i, lobe.probes.wide), fitted);
    }
    return probes_mirrors(sums, surface, lobe, fitted);
}

// As many mirrors, drawn from those that are visible: the mean over the samples of the reference converges to the integral.
Mirrors drawn_mirrors(const Surface surface, const vec3 wo, const vec3 S) {
    vec2 m = surface.mean_slope;
    DirectionArea o = direction_area(wo, m, slope_cholesky(S));
    uint seed = draw_seed(surface.pixel, lighting.draws.y, 0u);
    vec3 reflected = vec3(0.0), fresnel = vec3(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        vec2 u = drawn_point(lighting.draws.x * uint(SAMPLES) + uint(i), seed);
        DrawnMirror d = drawn_mirror(wo, u, m, S, o.visible);
        vec3 f = fresnel_of(surface, d.cosine);
        float variance = drawn_solid_angle(d.density, SAMPLES) / (4.0 * LEADR_PI); // per axis, of an even disc
        float lit = lit_fraction(SHADOWING, o, area_for(SHADOWING, d.wi, m, S, slope_cholesky(S)))
                  * relief_visibility(surface, d.wi, sqrt(variance));
        reflected += f * lit * lobe_radiance(surface, d.wi, variance);
        fresnel += fresnel_schlick(surface.body_f0, d.cosine);
    }
    return Mirrors(reflected / float(SAMPLES), fresnel / float(SAMPLES), o.visible);
}

// The same of measured facets.
Mirrors drawn_facets(const Surface surface, const FittedFacet facet) {
    uint seed = draw_seed(surface.pixel, lighting.draws.y, 0u);
    vec3 reflected = vec3(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        vec3 wi = fitted_direction_drawn(facet, drawn_point(lighting.draws.x * uint(SAMPLES) + uint(i), seed));
        float density = fitted_density(facet, wi);
        float variance = drawn_solid_angle(density, SAMPLES) / (4.0 * LEADR_PI);
        float lit = relief_visibility(surface, wi, sqrt(variance));
        reflected += fitted_reflected(facet, wi) * (lit / max(density, 1e-9)) * lobe_radiance(surface, wi, variance);
    }
    return Mirrors(reflected / float(SAMPLES), vec3(0.0), 1.0);
}

// probes: of the lobe, where it is looked up by these.
Mirrors gaussian_mirrors(const Surface surface, const vec3 wo, const vec3 S, const int probes) {
    if (DRAWN_MIRRORS) {
        return drawn_mirrors(surface, wo, S);
    }
    if (VISIBLE_SLOPES) {
        return probe_mirrors(surface, wo, S, probes);
    }
    return grid_mirrors(surface, wo, S);
}

// Mirrors of a GGX base: a mixture of Gaussian ones, each weighted by its visible area.
Mirrors ggx_mirrors(const Surface surface, const vec3 wo, const DisplacedGgx d) {
    Mirrors sum = Mirrors(vec3(0.0), vec3(0.0), 0.0);
    for (int k = 0; k < LEADR_GGX_LOBES; ++k) {
        GaussianLobe lobe = ggx_lobe(d, k);
        if (lobe.weight > 0.0) {
            Mirrors part = gaussian_mirrors(surface, wo, lobe.S, PROBES_OF_LOBE);
            float weight = lobe.weight * part.area;
            sum.reflected += weight * part.reflected;
            sum.fresnel += weight * part.fresnel;
            sum.area += weight;
        }
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    return Mirrors(sum.reflected * scale, sum.fresnel * scale, sum.area);
}

// Mean Fresnel reflectance of the body for mirrors of covariance S.
vec3 body_fresnel(const Surface surface, const vec3 wo, const vec3 S) {
    vec2 m = surface.mean_slope;
    return MAPPED ? mapped_fresnel(mapped_slopes(wo, m, surface.slope_covariance, S), surface.body_f0)
                  : visible_fresnel(wo, m, S, surface.body_f0);
}

// The mean Fresnel reflectance alone, for when no environment is looked up.
vec3 ggx_fresnel(const Surface surface, const vec3 wo, const DisplacedGgx d) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < LEADR_GGX_LOBES; ++k) {
        GaussianLobe lobe = ggx_lobe(d, k);
        float area = MAPPED ? 1.0 : visible_area(wo, surface.mean_slope, lobe.S);
        sum += lobe.weight * area * vec4(body_fresnel(surface, wo, lobe.S), 1.0);
    }
    return sum.rgb / max(sum.w, 1e-12);
}

// Irradiance that order 2 leaves out, for a normal n of any length; none with the grid of the paper, which is of order 2.
vec3 rest_irradiance(const Surface surface, const vec3 n) {
    return VISIBLE_SLOPES ? textureLod(irradiance_rest, from_frame(surface.frame, n), 0.0).rgb : vec3(0.0);
}

// Diffuse radiance of the environment per unit of albedo.
vec3 diffuse_environment(const Surface surface, const NormalMoments normals) {
    vec3 c[9] = environment_sh();
    vec3 whole;
    float open = 1.0; // bumps hide what facets do not hide from each other already
    if (SHADOWING == LEADR_SHADOWING_CORRELATED) {
        BentNormal bent = bent_normal(surface.wo, surface.mean_slope, surface.slope_covariance);
        whole = shadowed_diffuse_environment(bent, surface.frame, c, rest_irradiance(surface, bent.normal));
        open = bent.open;
    } else {
        vec3 rest = rest_irradiance(surface, normals.mean) * sh_rest_damping(normals.mean);
        whole = leadr_diffuse_environment(normals, surface.frame, c, rest);
    }
    if (!USES_HORIZON) {
        return max(whole, 0.0);
    }
    vec2 m = surface.mean_slope;
    return diffuse_past_horizon(whole, open, horizon_hidden(m, surface.horizon), m, surface.frame, c);
}

// Share of the environment's light in all mirrors that a cone leaves.
float mirrors_in_cone(const Surface surface) {
    vec3 S = add_roughness(surface.slope_covariance, surface.alpha);
    return cone_mirrors(surface, sqrt(2.0 * normal_variance(surface.mean_slope, S)));
}

// Albedo of what is seen, weighted by the environment's irradiance where slopes decide. c: its coefficients.
vec3 environment_albedo(const Surface surface, const DirectionArea o) {
    vec3 S = surface.slope_covariance, wo = surface.wo;
    vec2 m = surface.mean_slope;
    // Relief of a normal map hides nothing: its facets count by their area on the surface, as if seen from above.
    float open = SHADOWING == LEADR_SHADOWING_NONE || MAPPED ? 1.0 : bent_normal(wo, m, S).open;
    SlopesScore score = SlopesScore(vec2(0.0), vec3(0.0));
    if (!MAPPED) {
        score = seen_slopes_score(wo, m, S);
    }
    vec2 seen = score.moved;
    // The change of the irradiance with the slope, by differences over a deviation.
    vec2 middle = m + vec2(S.x * seen.x + S.z * seen.y, S.z * seen.x + S.y * seen.y), step = sqrt(max(S.xy, 1e-6));
    vec3 c[9] = environment_sh();
    vec3 irradiance[4];
    for (int i = 0; i < 4; ++i) {
        vec2 aside = vec2(i < 2 ? step.x : 0.0, i < 2 ? 0.0 : step.y) * ((i & 1) == 0 ? 1.0 : -1.0);
        irradiance[i] = max(sh_irradiance(c, from_frame(surface.frame, normal_of_slope(middle + aside))), 0.0);
    }
    vec3 x = (irradiance[0] - irradiance[1]) / (max(irradiance[0] + irradiance[1], 1e-9) * step.x);
    vec3 y = (irradiance[2] - irradiance[3]) / (max(irradiance[2] + irradiance[3], 1e-9) * step.y);
    vec3 change = slopes_change(surface.relief_color, seen.x + x, seen.y + y, score.narrowed, S);
    return relief_color(surface.albedo, surface.relief_color, MAPPED ? 0.0 : seen_height(o, open), change);
}

// Diffuse radiance of a light of unit irradiance per unit of albedo, without shadows.
float diffuse_light(const Surface surface, const vec3 wo, const NormalMoments normals, const vec2 faced, const float lambda,
                    const vec3 wi) {
    vec3 S = surface.slope_covariance;
    if (MAPPED && !LIGHTS_BY_SH) {
        return mapped_diffuse_light(wi, surface.mean_slope, S, DIFFUSE_TERMS);
    }
    if (LIGHTS_BY_SH) {
        return leadr_diffuse_light_sh(normals, wo, wi, faced, S, false);
    }
    return VISIBLE_SLOPES ? leadr_diffuse_light_visible(wo, wi, surface.mean_slope, S, false, DIFFUSE_TERMS)
                          : leadr_diffuse_light(wo, wi, faced, S, false, SAMPLES, lambda);
}

// What measured facets reflect of a light, per unit of irradiance; of one with a size, from a direction that is drawn.
vec3 facet_light(const Surface surface, const FittedFacet facet, const int number, const Light light) {
    vec3 wi = light.wi;
    if (of_panorama(number)) {
        vec2 u = drawn_point(lighting.draws.x, draw_seed(surface.pixel, lighting.draws.y, uint(1 + number)));
        float radius = sqrt(-2.0 * light.variance * log(max(1.0 - u.x, 1e-7))), phi = 6.28318531 * u.y;
        Frame about = frame_about(wi);
        wi = normalize(wi + radius * (cos(phi) * about.x + sin(phi) * about.y));
    }
    return fitted_reflected(facet, wi);
}

// Roughness and weight of each of the bases that share the surface; weights sum to one. A measured material has as many as lobes.
const int OWN_BASES = MIXED_ROUGHNESS ? 2 : 1;
const int BASES = FIT_LOBES > OWN_BASES ? FIT_LOBES : OWN_BASES;
const int MOST_BASES = 4;

void bases_of(const Surface surface, out vec2 bases[MOST_BASES]) {
    for (int i = 0; i < MOST_BASES; ++i) {
        bases[i] = vec2(surface.alpha, i == 0 ? 1.0 : 0.0);
    }
    if (MIXED_ROUGHNESS) {
        bases[0] = vec2(surface.mixed.smooth_alpha, 1.0 - surface.mixed.share);
        bases[1] = vec2(surface.mixed.rough_alpha, surface.mixed.share);
    }
    if (is_fitted(surface.fit)) {
        // Lobes count as the viewer sees their facets.
        float stretch = fit_stretch(surface.fit, surface.alpha), all = 0.0;
        int lobes = fitted_lobes(surface.fit);
        for (int i = 0; i < MOST_BASES; ++i) {
            FittedLobe lobe = fitted_lobe(surface.fit, min(i, lobes - 1), stretch);
            float area = MAPPED ? 1.0 : visible_area(surface.wo, surface.mean_slope, add_roughness(surface.slope_covariance, lobe.alpha));
            bases[i] = vec2(lobe.alpha, i < lobes ? lobe.share * area : 0.0);
            all += bases[i].y;
        }
        for (int i = 0; i < MOST_BASES; ++i) {
            bases[i].y /= max(all, 1e-12);
        }
    }
}

// The mirrors of a base of one roughness on the relief.
struct Base {
    float alpha;
    vec3 S;           // covariance of the mirrors
    DisplacedGgx ggx; // instead, where the base is GGX
    vec3 cholesky;
    DirectionArea o;  // area seen by the viewer
};

Base base_of(const Surface surface, float alpha) {
    vec3 relief = surface.slope_covariance, wo = surface.wo;
    vec2 m = surface.mean_slope;
    Base base;
    base.alpha = alpha;
    base.S = FACET_FRAME && !FINEST_LEVEL ? add_facet_roughness(relief, alpha, wo, m) : add_roughness(relief, alpha);
    if (GGX_BASE) {
        base.ggx = displaced_ggx(vec3(vec2(alpha * alpha), 0.0), relief);
    }
    if (any_on_diffuse() || any_in_mirrors()) {
        base.cholesky = slope_cholesky(GGX_BASE ? 0.5 * base.ggx.roughness : base.S);
        base.o = GGX_BASE ? displaced_ggx_area(wo, m, base.ggx, base.cholesky) : area_for(SHADOWING, wo, m, base.S, base.cholesky);
    }
    return base;
}

// Specular radiance of a light with a size, per unit of irradiance: its directions widen the lobe. o: area seen by the viewer.
vec3 sized_light(const Surface surface, const DirectionArea o, const Light light, const vec3 S, const DisplacedGgx ggx,
                 const vec3 cholesky) {
    vec3 size = light_slope_covariance(surface.wo, light.wi, light.variance);
    vec2 m = surface.mean_slope;
    if (MAPPED && !GGX_BASE) {
        return mapped_specular_light(surface.wo, light.wi, m, clamp_covariance(S + size), surface.f0);
    }
    if (!GGX_BASE) {
        DirectionArea i = area_for(SHADOWING, light.wi, m, S, cholesky);
        return leadr_specular_light(SHADOWING, o, i, surface.wo, light.wi, m, clamp_covariance(S + size), surface.f0);
    }
    vec3 h = surface.wo + light.wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float lit = MAPPED ? 1.0 / max(half_facet_area(surface.wo, light.wi, wh), LEADR_MIN_AREA)
                       : masking_shadowing_factor(SHADOWING, o, displaced_ggx_area(light.wi, m, ggx, cholesky));
    DisplacedGgx wider = DisplacedGgx(ggx.weight, 2.0 * clamp_covariance(0.5 * ggx.roughness + size));
    return fresnel_schlick(surface.f0, dot(light.wi, wh)) * (0.25 * displaced_ggx_ndf(wh, m, wider) * lit);
}

// What a base reflects of the environment.
Mirrors environment_mirrors(const Surface surface, const Base base) {
    if (GGX_BASE) {
        return ggx_mirrors(surface, surface.wo, base.ggx);
    }
    return gaussian_mirrors(surface, surface.wo, base.S, SAMPLES);
}

// The body's mean Fresnel reflectance alone.
vec3 mean_fresnel(const Surface surface, const Base base) {
    return GGX_BASE ? ggx_fresnel(surface, surface.wo, base.ggx) : body_fresnel(surface, surface.wo, base.S);
}

// What it reflects of a light, per unit of irradiance. diffuse_o, diffuse_i, diffuse_cholesky: of the relief without its base.
vec3 mirrored_light(const Surface surface, const Base base, const int number, const Light light, const DirectionArea diffuse_o,
                    const DirectionArea diffuse_i,
                    const vec3 diffuse_cholesky) {
    vec3 wo = surface.wo, f0 = surface.f0;
    vec2 m = surface.mean_slope;
    if (!in_mirrors(number)) {
        return vec3(0.0);
    }
    if (FACET_MIRRORS) {
        FacetMirrors mirrors = facet_mirrors(wo, light.wi, base.alpha, light.variance);
        return facet_mirrors_light(SHADOWING, diffuse_o, diffuse_i, mirrors, m, diffuse_cholesky, f0);
    }
    if (of_panorama(number)) {
        return sized_light(surface, base.o, light, base.S, base.ggx, base.cholesky);
    }
    if (MAPPED && GGX_BASE) {
        return sized_light(surface, base.o, Light(light.wi, light.irradiance, 0.0), base.S, base.ggx, base.cholesky);
    }
    if (GGX_BASE) {
        return displaced_ggx_light(SHADOWING, base.o, wo, light.wi, m, base.ggx, base.cholesky, f0);
    }
    if (MAPPED) {
        return mapped_specular_light(wo, light.wi, m, base.S, f0);
    }
    if (SHADOWING == LEADR_SHADOWING_NONE) {
        return leadr_specular_directional(wo, light.wi, m, base.S, f0, false);
    }
    DirectionArea i = area_for(SHADOWING, light.wi, m, base.S, base.cholesky);
    return leadr_specular_light(SHADOWING, base.o, i, wo, light.wi, m, base.S, f0);
}

// Passes that shade all kinds of surfaces take those of one lobe through the loop of measured ones, since drivers in software take both
// sides of every branch: nodes of each turn, those of a lobe's rule, and of one rule of SAMPLES nodes that is spread over the turns.
const bool SHARES_PROBES = FIT_LOBES > OWN_BASES && VISIBLE_SLOPES && !DRAWN_MIRRORS;
const int LOBE_NODES = FIT_LOBES == 2 ? 9 : FIT_LOBES == 3 ? 6 : 5;
const int LOBE_RULE = FIT_LOBES == 2 ? 9 : PROBES_OF_LOBE;
const int SPREAD_NODES = FIT_LOBES == 2 ? (SAMPLES + 1) / 2 : FIT_LOBES == 3 ? (SAMPLES + 2) / 3 : (SAMPLES + 3) / 4;

// The environment in lobes of measured materials, each by a rule of its own, and in bases of one lobe.
Mirrors shared_probes(Surface surface, const vec2 bases[MOST_BASES]) {
    vec3 wo = surface.wo;
    bool fitted = is_fitted(surface.fit);
    bool several = fitted || (MIXED_ROUGHNESS && bases[1].y > 0.0);
    vec3 kernel = several ? probe_kernel(LOBE_RULE) : probe_kernel(SAMPLES);
    Mirrors sum = Mirrors(vec3(0.0), vec3(0.0), 0.0);
    ProbeSums sums = ProbeSums(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0);
    for (int i = 0; i < FIT_LOBES; ++i) {
        ProbedLobe lobe = probed_lobe(surface, wo, base_of(surface, bases[several ? i : 0].x).S, kernel);
        [[unroll]] for (int j = 0; j < LOBE_NODES; ++j) {
            int spread = i * SPREAD_NODES + j;
            ProbeNode node = probe_node(LOBE_RULE, min(j, LOBE_RULE - 1), lobe.probes.wide);
            bool counts = j < LOBE_RULE;
            if (!several) {
                node = probe_node(SAMPLES, min(spread, SAMPLES - 1), lobe.probes.wide);
                counts = j < SPREAD_NODES && spread < SAMPLES;
            }
            node.weight = counts ? node.weight : 0.0;
            add_probe(sums, surface, wo, lobe, node, fitted);
        }
        if (several || i == FIT_LOBES - 1) {
            Mirrors part = probes_mirrors(sums, surface, lobe, fitted);
            float weight = several ? bases[i].y : 1.0;
            sum.reflected += weight * part.reflected;
            sum.fresnel += weight * part.fresnel;
            sums = ProbeSums(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0);
        }
    }
    return sum;
}

// The environment in the mirrors of all bases.
Mirrors mirrors_of(const Surface surface, const vec2 bases[MOST_BASES]) {
    if (SHARES_PROBES) {
        return shared_probes(surface, bases);
    }
    Mirrors sum = Mirrors(vec3(0.0), vec3(0.0), 0.0);
    if (BASES > 2) {
        for (int i = 0; i < BASES; ++i) {
            Mirrors part = environment_mirrors(surface, base_of(surface, bases[i].x));
            sum.reflected += bases[i].y * part.reflected;
            sum.fresnel += bases[i].y * part.fresnel;
        }
        return sum;
    }
    // One or two are written out, which is faster; for more, drivers would take ten seconds to compile that.
    [[unroll]] for (int i = 0; i < min(BASES, 2); ++i) {
        Mirrors part = environment_mirrors(surface, base_of(surface, bases[i].x));
        sum.reflected += bases[i].y * part.reflected;
        sum.fresnel += bases[i].y * part.fresnel;
    }
    return sum;
}

// The body's mean Fresnel reflectance under the mirrors of all bases.
vec3 fresnel_under(const Surface surface, const vec2 bases[MOST_BASES]) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < BASES; ++i) {
        sum += bases[i].y * mean_fresnel(surface, base_of(surface, bases[i].x));
    }
    return sum;
}

// The body's mean Fresnel reflectance without relief, as one bounce has it.
vec3 smooth_fresnel(Surface surface, const Bounces bounces) {
    surface.mean_slope = vec2(0.0);
    surface.slope_covariance = vec3(0.0);
    surface.wo = bounces.wo;
    return mean_fresnel(surface, base_of(surface, bounces.alpha));
}

// A light in the mirrors of all bases, per unit of irradiance; the arguments as in mirrored_light.
vec3 light_in_mirrors(const Surface surface, const vec2 bases[MOST_BASES], const int number, const Light light,
                      const DirectionArea diffuse_o, const DirectionArea diffuse_i,
                      const vec3 diffuse_cholesky) {
    vec3 sum = vec3(0.0);
    if (BASES > 2) {
        for (int i = 0; i < BASES; ++i) {
            if (bases[i].y > 0.0) {
                Base base = base_of(surface, bases[i].x);
                sum += bases[i].y * mirrored_light(surface, base, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
            }
        }
    } else {
        [[unroll]] for (int i = 0; i < min(BASES, 2); ++i) {
            Base base = base_of(surface, bases[i].x);
            sum += bases[i].y * mirrored_light(surface, base, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
        }
    }
    return sum * fresnel_over_schlick(surface.fit, surface.f0, surface.dip, 0.5 * length(surface.wo + light.wi));
}

vec3 leadr_radiance(Surface surface) {
    vec3 wo = surface.wo;
    vec2 m = surface.mean_slope;
    vec3 diffuse_s = surface.slope_covariance;
    // Bases that share the surface have mirrors of their own.
    vec2 bases[MOST_BASES];
    bases_of(surface, bases);
    bool exact = FINEST_LEVEL && is_fitted(surface.fit);
    Bounces bounces;
    if (MULTISCATTERING) {
        bounces = bounces_of(surface, surface.alpha);
    }
    FittedFacet facet;
    if (exact) {
        vec2 u = drawn_point(lighting.draws.x, draw_seed(surface.pixel, lighting.draws.y, FACET_DRAW));
        vec3 normal = fitted_normal(surface.fit, wo, m, diffuse_s, MAPPED, u);
        facet = fitted_facet(surface.fit, surface.alpha, wo, normal, diffuse_s);
    }
    vec3 radiance = vec3(0.0);

    // Light that the visible mirrors do not reflect enters the surface; the diffuse term returns no more than that.
    vec3 entering = vec3(1.0);
    if (SPECULAR_ENVIRONMENT) {
        Mirrors mirrors;
        if (exact) {
            mirrors = drawn_facets(surface, facet);
        } else {
            mirrors = mirrors_of(surface, bases);
        }
        if (MULTISCATTERING) {
            mirrors.reflected *= bounces.mirrors;
        }
        radiance += ambient_in_mirrors(surface) * mirrors_in_cone(surface) * mirrors.reflected;
        entering = 1.0 - mirrors.fresnel;
    } else if (DIFFUSE && !exact) {
        entering = 1.0 - fresnel_under(surface, bases);
    }
    if (MULTISCATTERING && DIFFUSE && !exact) {
        entering *= bounces.entered / max(1.0 - smooth_fresnel(surface, bounces), vec3(1e-3));
    }

    vec3 diffuse_cholesky = slope_cholesky(diffuse_s);
    DirectionArea diffuse_o = area_for(SHADOWING, wo, m, diffuse_s, diffuse_cholesky);
    float lambda = grid_lambda(SAMPLES);
    vec2 faced = face_viewer(wo, m, diffuse_s, lambda);
    NormalMoments normals;
    if ((DIFFUSE_ENVIRONMENT && SHADOWING != LEADR_SHADOWING_CORRELATED) || (any_on_diffuse() && LIGHTS_BY_SH)) {
        normals = MAPPED ? mapped_diffuse_moments(m, diffuse_s, DIFFUSE_TERMS)
                : VISIBLE_SLOPES ? visible_diffuse_moments(wo, m, diffuse_s, DIFFUSE_TERMS)
                                 : visible_normal_moments(wo, faced, diffuse_s, SAMPLES, lambda);
    }
    if (DIFFUSE_ENVIRONMENT) {
        vec3 albedo = USES_RELIEF_COLOR ? environment_albedo(surface, diffuse_o) : surface.albedo;
        if (MULTISCATTERING) {
            albedo *= first_albedo(bounces.facets, albedo);
        }
        vec3 ambient = ambient_on_diffuse(surface, albedo) * cone_diffuse(surface, albedo, environment_sh());
        radiance += entering * albedo * ambient * diffuse_environment(surface, normals);
    }
    if (any_on_diffuse() || any_in_mirrors()) {
        [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
            Light light = light_at(number, surface);
            vec3 scattered = vec3(0.0);
            DirectionArea diffuse_i;
            if (on_diffuse(number) || (FACET_MIRRORS && in_mirrors(number))) {
                diffuse_i = area_for(SHADOWING, light.wi, m, diffuse_s, diffuse_cholesky);
            }
            if (on_diffuse(number)) {
                float lit = lit_fraction(SHADOWING, diffuse_o, diffuse_i);
                vec3 albedo = surface.albedo;
                if (USES_RELIEF_COLOR) {
                    float height = MAPPED ? 0.0 : seen_height(diffuse_o, lit);
                    SlopesScore score = lit_slopes_score(MAPPED ? vec3(0.0, 0.0, 1.0) : wo, light.wi, m, diffuse_s);
                    vec3 change = slopes_change(surface.relief_color, score, surface.slope_covariance);
                    albedo = relief_color(albedo, surface.relief_color, height, change);
                }
                scattered += entering * albedo * (lit * diffuse_light(surface, wo, normals, faced, lambda, light.wi));
                if (MULTISCATTERING) {
                    scattered *= bounced_light(bounces, surface, albedo, light.wi);
                }
            }
            vec3 mirrored = vec3(0.0);
            if (exact) {
                mirrored = in_mirrors(number) ? facet_light(surface, facet, number, light) : vec3(0.0);
            } else {
                mirrored = light_in_mirrors(surface, bases, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
                if (MULTISCATTERING) {
                    mirrored *= bounces.mirrors;
                }
            }
            radiance += light.irradiance * (scattered + mirrored);
        }
    }
    return radiance;
}

#endif
