// Computes LEADR's integrals over the visible slopes. Specular lights use eq. 17. The specular environment uses eq. 19 and 22, on the
// paper's grid (Algorithm 1) or with a few probes. Diffuse light uses eq. 20-23 (Algorithms 2 and 3), on the grid, in closed form, or with
// one lookup for shadowed environments.
#ifndef LEADR_SHADE_LEADR
#define LEADR_SHADE_LEADR
#include "draws.glsl"
#include "fitted_facets.glsl"
#include "bounces.glsl"
#include "classes.glsl"
#include "harmonics.glsl"
#include "interreflection.glsl"
#include "lighting.glsl"
#include "pixel_kernel.glsl"
#include "leadr/facets/base_roughness.glsl"
#include "leadr/integrals/diffuse.glsl"
#include "leadr/integrals/facet_specular.glsl"
#include "leadr/integrals/ggx_lobes.glsl"
#include "leadr/integrals/light_size.glsl"
#include "leadr/integrals/phong.glsl"
#include "leadr/visible/shadowed_environment.glsl"
#include "leadr/visible/shadowed_specular.glsl"
#include "leadr/integrals/specular.glsl"
#include "leadr/materials/classic.glsl"
#include "leadr/visible/clear_coat.glsl"
#include "leadr/visible/diffuse.glsl"
#include "leadr/visible/fresnel.glsl"
#include "leadr/visible/grazing.glsl"
#include "leadr/visible/mapped.glsl"
#include "leadr/visible/specular.glsl"

const float GRID_DEVIATION = 0.05; // angular deviation of the light of one grid sample, for the horizon of the relief
const bool FACET_SPECULAR = FACET_FRAME && !FINEST_LEVEL && !GGX_BASE && !PHONG_FACETS && !V_GROOVES; // whether lights use facet_specular.glsl

// The means over the visible specular facets.
struct SpecularTerm {
    vec3 reflected; // reflected radiance, including Fresnel term and shadowing
    vec3 fresnel;   // fraction of light that does not enter the diffuse base
    float area;     // visible area in arbitrary units, which is the weight among several lobes
};

// Converts the specular term of the facets of a normal map that face the viewer to that of all facets. Facets that face away are black, and
// have the reflectance of grazing incidence.
SpecularTerm of_facing(const SpecularTerm specular, const Surface surface, const float facing) {
    vec3 grazing = grazing_reflectance(surface.diffuse_f0);
    return SpecularTerm(facing * specular.reflected, mix(grazing, specular.fresnel, facing), 1.0);
}

// Returns the fraction of the light from wi that passes the coat of a surface, including light between coat and specular base. The loss toward
// the viewer is not included. `cosine` belongs to the facet of the base.
vec3 passed_coat(const Surface surface, const vec3 wi, const float cosine) {
    vec3 w = normalize(wi);
    vec2 m = surface.mean_slope;
    vec3 S = surface.slope_covariance;
    if (surface.coat.own) {
        w = to_frame(frame_about(surface.coat_normal), from_frame(surface.frame, w));
        m = surface.coat.mean_slope;
        S = surface.coat.covariance;
    }
    float inward = coat_reflectance(w, m, add_roughness(S, surface.coat.alpha), surface.coat.weight, EXACT_FRESNEL);
    return coated_base(0.0, inward, inward, fresnel_of(surface, cosine));
}

// Adds a facet with the reflected direction and the weight of a node, and sums the weights in `area`. lod is the level of detail of the
// environment.
void add_facet(inout SpecularTerm sum, const EnvironmentSample e, const float weight, const Surface surface, const vec3 wo, const vec2 m,
               const vec3 S, const vec3 cholesky, const DirectionArea o, const float lod) {
    float cosine = dot(wo, e.wn);
    vec3 f = weight * fresnel_of(surface, cosine);
    float lit = is_class(surface) ? class_lit(surface, e.wi) * class_base_lit(surface, e.wi) : lit_fraction(FACET_SHADOWING, o, area_for(FACET_SHADOWING, e.wi, m, S, cholesky));
    if (V_GROOVES) {
        lit = groove_lit_fraction(e.area, e.area, o.meso, meso_area(e.wi, m));
    }
    lit *= relief_visibility(surface, e.wi, GRID_DEVIATION);
    if (COATED && surface.under_coat) {
        f *= passed_coat(surface, e.wi, cosine);
    }
    sum.reflected += f * lit * environment_radiance(surface, e.wi, lod);
    sum.fresnel += weight * diffuse_fresnel_of(surface, cosine);
    sum.area += weight;
}

// Adds one node of the grid. relief is the fraction of the slope variance that a normal map contributes. The facets of a normal map have
// equal weights.
void add_grid_specular(inout SpecularTerm sum, const vec3 node, const Surface surface, const vec3 wo, const vec2 m, const vec3 S,
                       const vec3 cholesky, const DirectionArea o, const float base, const float relief) {
    EnvironmentSample e = environment_sample_at(wo, slope_at(node.xy, m, cholesky));
    float weight = node.z * e.area;
    if (MAPPED) {
        weight = node.z * mix(e.area, e.area > 0.0 ? max(o.meso, 1e-3) : 0.0, relief);
    } else if (V_GROOVES) {
        weight = node.z * groove_visible_area(e.area, o.meso);
    }
    add_facet(sum, e, weight, surface, wo, m, S, cholesky, o, env_lod_at(base, wo, e.wn));
}

// Grids with up to this many samples per side are unrolled, which is a sixth faster (docs/measurements/performance.md).
const int WRITTEN_OUT = 5;

// Adds a sample with another placement than the grid. Samples of weight 0 look nothing up.
void add_placed(inout SpecularTerm sum, const SlopeNode node, const Surface surface, const vec3 wo, const SlopeNodes nodes, const vec3 S,
                const DirectionArea o, const float per_cell, const float relief) {
    EnvironmentSample e = environment_sample_at(wo, node.slope);
    if (node.weight <= 0.0 || e.area <= 0.0) {
        return;
    }
    // The facets of a normal map have equal weights.
    float weight = MAPPED ? node.weight * mix(1.0, max(o.meso, 1e-3) / e.area, relief) : node.weight;
    float lod = env_lod_at(per_cell + 0.5 * log2(node.cell), wo, e.wn);
    add_facet(sum, e, weight, surface, wo, nodes.m, S, nodes.cholesky, o, lod);
}

// Returns the specular term from samples with another placement than the grid.
SpecularTerm placed_specular(const Surface surface, const vec3 wo, const vec3 S, const MappedSlopes mapped) {
    SlopeNodes nodes = slope_nodes(GRID_NODES, wo, surface.mean_slope, S, SAMPLES);
    DirectionArea o = area_for(FACET_SHADOWING, wo, nodes.m, S, nodes.cholesky);
    float per_cell = env_lod_base(S, 1.0, lighting.environment.x, GRID_LOD);
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    for (int j = 0; j < SAMPLES; ++j) {
        float row = node_row(nodes, j);
        for (int k = 0; k < SAMPLES; ++k) {
            add_placed(sum, slope_node(nodes, wo, row, k), surface, wo, nodes, S, o, per_cell, mapped.relief);
        }
    }
    if (GRID_NODES == LEADR_NODES_MICRONORMAL) {
        add_placed(sum, artificial_node(nodes, wo), surface, wo, nodes, S, o, per_cell, mapped.relief);
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    SpecularTerm mean = SpecularTerm(sum.reflected * scale, sum.fresnel * scale, o.visible);
    return MAPPED ? of_facing(mean, surface, mapped.facing) : mean;
}

// Evaluates Algorithm 1. Loop invariants are computed outside the loop.
SpecularTerm grid_specular(Surface surface, vec3 wo, vec3 S) {
    float lambda = grid_lambda(SAMPLES);
    vec2 m = face_viewer(wo, surface.mean_slope, S, lambda);
    vec3 cholesky = slope_cholesky(S);
    DirectionArea o = area_for(FACET_SHADOWING, wo, m, S, cholesky);
    float base = env_lod_base(S, grid_spacing(SAMPLES, lambda), lighting.environment.x, GRID_LOD);
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    MappedSlopes mapped;
    if (MAPPED) {
        mapped = mapped_slopes(wo, surface.mean_slope, surface.slope_covariance, S);
    }
    float relief = MAPPED ? mapped.relief : 0.0;
    if (GRID_NODES != LEADR_NODES_GRID) {
        return placed_specular(surface, wo, S, mapped);
    }
    if (SAMPLES <= WRITTEN_OUT) {
        [[unroll]] for (int i = 0; i < min(SAMPLES, WRITTEN_OUT) * min(SAMPLES, WRITTEN_OUT); ++i) {
            add_grid_specular(sum, grid_node(i / SAMPLES, i % SAMPLES, SAMPLES, lambda), surface, wo, m, S, cholesky, o, base, relief);
        }
    } else {
        for (int j = 0; j < SAMPLES; ++j) {
            for (int k = 0; k < SAMPLES; ++k) {
                add_grid_specular(sum, grid_node(j, k, SAMPLES, lambda), surface, wo, m, S, cholesky, o, base, relief);
            }
        }
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    SpecularTerm mean = SpecularTerm(sum.reflected * scale, sum.fresnel * scale, V_GROOVES ? max(o.meso, LEADR_MIN_AREA) : o.visible);
    return MAPPED ? of_facing(mean, surface, mapped.facing) : mean;
}

// The number of probes per lobe, for three or more lobes (docs/measurements/fitting.md gives the error).
const int PROBES_OF_LOBE = 5;
// The number of probes of the class with the largest share. The others have FEWEST_PROBES. Two classes that hide nothing from each other
// have 9 each, and see as much of the environment as one.
const int MOST_CLASS_PROBES = BY_CLASS || CLASSES > 2 ? PROBES_OF_LOBE : 9;
const int FEWEST_PROBES = 3;

// The positions of a lobe's probes, and the visible area of the lobe.
struct ProbedLobe {
    VisibleProbes probes;
    DirectionArea o;
    float facing; // fraction of the facets of a normal map that face the viewer
};

// Returns the probes of a lobe. kernel belongs to the lobe's quadrature rule.
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

// Whether all visible facets are lit.
const bool UNSHADOWED = (MAPPED || SHADOWING == LEADR_SHADOWING_NONE) && !HAS_HORIZON;

// The sums over probes. The weights of the probes add up to one.
struct ProbeSums {
    vec3 at_normal;  // radiance as if all light were reflected
    vec3 by_angle;   // this radiance times Schlick's term or, for a table of reflectances, times the cosine
    float lit;
    float grazing;   // sum of Schlick's term
    float cosine;
    float cosine2;
    vec3 exact;      // with EXACT_FRESNEL, radiance times the deviation of the Fresnel term from Schlick's
    vec3 deviation;  // sum of this deviation
};

const ProbeSums NO_PROBES = ProbeSums(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0, vec3(0.0), vec3(0.0));

// Adds a probe. fitted is whether a table of reflectances multiplies the radiance.
void add_probe(inout ProbeSums sums, const Surface surface, const vec3 wo, const ProbedLobe lobe, const ProbeNode node, const bool fitted) {
    VisibleProbe p = visible_probe(lobe.probes, wo, node);
    // The grazing part of the lobe of a class has its own lookup.
    float mean_f0 = is_class(surface) ? 1.0 : dot(surface.f0, vec3(1.0 / 3.0));
    LitProbe l;
    if (is_class(surface)) {
        ProbeDirections d = probe_directions(lobe.probes, p);
        vec2 lit = vec2(class_lit(surface, d.high) * class_base_lit(surface, d.high),
                        class_lit(surface, d.low) * class_base_lit(surface, d.low));
        l = lit_probe(LEADR_SHADOWING_NONE, lobe.probes, lobe.o, wo, mean_f0, p, d, lit, HAS_HORIZON, surface.horizon);
    } else {
        l = lit_probe(MAPPED ? LEADR_SHADOWING_NONE : SHADOWING, lobe.probes, lobe.o, wo, mean_f0, p, HAS_HORIZON, surface.horizon);
    }
    vec3 radiance = p.weight * lobe_radiance(surface, l.wi, l.narrowing * p.variance);
    if (COATED && surface.under_coat) {
        radiance *= passed_coat(surface, l.wi, p.cosine);
    }
    sums.at_normal += l.lit * radiance;
    sums.by_angle += (fitted ? l.lit * p.cosine : l.grazing) * radiance;
    sums.lit += p.weight * l.lit;
    sums.grazing += p.weight * schlick_weight(p.cosine);
    sums.cosine += p.weight * p.cosine;
    sums.cosine2 += p.weight * p.cosine * p.cosine;
    if (EXACT_FRESNEL && !fitted) {
        vec3 deviation = fresnel_deviation(surface.f0, surface.index, p.cosine);
        sums.exact += l.lit * deviation * radiance;
        sums.deviation += p.weight * deviation;
    }
}

// Returns the specular term from sums over probes.
SpecularTerm probes_specular(const ProbeSums sums, const Surface surface, const ProbedLobe lobe, const bool fitted) {
    vec3 reflected;
    vec3 deviation = EXACT_FRESNEL && !fitted ? mean_deviation(lobe.probes.cosines, surface.f0, surface.index) : vec3(0.0);
    if (fitted) {
        // The table is nearly linear over a lobe. A line passes through its values at the mean cosine plus and minus one standard
        // deviation.
        float spread = max(sqrt(max(sums.cosine2 - sums.cosine * sums.cosine, 0.0)), 1e-3);
        float high = min(sums.cosine + spread, 1.0), low = max(high - 2.0 * spread, 0.0);
        vec3 at_low = fitted_fresnel(surface.fit, low), slope = (fitted_fresnel(surface.fit, high) - at_low) / (high - low);
        reflected = max((at_low - low * slope) * sums.at_normal + slope * sums.by_angle, 0.0);
    } else {
        // The edge tint varies slowly with the angle, so its mean over the lobe is approximated by its value at the mean cosine.
        vec3 rise = grazing_reflectance(surface.f0) - surface.f0;
        if (UNSHADOWED) {
            // The diffuse term has what the exact mean of Schlick's term leaves.
            rise *= lobe.probes.grazing / max(sums.grazing, 1e-9);
        }
        if (EXACT_FRESNEL) {
            reflected = max((surface.f0 + deviation - sums.deviation) * sums.at_normal + rise * sums.by_angle + sums.exact, 0.0);
        } else {
            reflected = (surface.f0 - surface.edge_tint * edge_tint_weight(sums.cosine)) * sums.at_normal + rise * sums.by_angle;
        }
    }
    if (INTERREFLECTION) {
        vec3 f0 = fitted ? fitted_fresnel(surface.fit, sums.cosine) : surface.f0;
        vec3 mean = f0 + (fitted ? vec3(0.0) : (grazing_reflectance(f0) - f0) * lobe.probes.grazing) + deviation;
        reflected += mean * max(1.0 - sums.lit, 0.0) * surface.relief_radiance;
    }
    vec3 diffuse_f0 = surface.diffuse_f0;
    vec3 fresnel = diffuse_f0 + (grazing_reflectance(diffuse_f0) - diffuse_f0) * lobe.probes.grazing;
    if (EXACT_FRESNEL) {
        fresnel = clamp(fresnel + mean_deviation(lobe.probes.cosines, diffuse_f0, surface.diffuse_index), 0.0, 1.0);
    }
    SpecularTerm mean = SpecularTerm(reflected / max(sums.lit, 1.0), fresnel, lobe.probes.area);
    return MAPPED ? of_facing(mean, surface, lobe.facing) : mean;
}

// Returns the specular term from `count` probes among the visible slopes.
SpecularTerm probe_specular(Surface surface, vec3 wo, const vec3 S, int count) {
    ProbeSums sums = NO_PROBES;
    bool fitted = is_fitted(surface.fit);
    ProbedLobe lobe = probed_lobe(surface, wo, S, probe_kernel(count));
    [[unroll]] for (int i = 0; i < count; ++i) {
        add_probe(sums, surface, wo, lobe, probe_node(count, i, lobe.probes.wide), fitted);
    }
    return probes_specular(sums, surface, lobe, fitted);
}

// Returns the environment in the grazing part of a class's lobe, weighted by Schlick's term.
vec3 class_grazing(const Surface surface, const vec3 wo, const vec3 S) {
    VisibleSlopes v = visible_slopes(wo, surface.mean_slope, S);
    vec3 up = normal_of_slope(surface.whole_mean);
    GrazingLobe g = grazing_lobe(SHADOWING, wo, v, up, shaded_class.base_area, base_variance(surface));
    // The lit fraction is concave in the height of the direction, so two heights give its mean.
    ProbeDirections d = split_direction(up, g.wi, g.spread);
    float lit = 0.5 * g.weight * (class_lit(surface, d.high) + class_lit(surface, d.low));
    if (HAS_HORIZON) {
        Horizon h = raised_horizon(surface.horizon, LEADR_SPECULAR_HORIZON);
        lit *= horizon_visibility(g.wi, surface.mean_slope, h, sqrt(g.variance));
    }
    vec3 radiance = lit * lobe_radiance(surface, g.wi, g.variance);
    if (COATED && surface.under_coat) {
        radiance *= passed_coat(surface, g.wi, 0.5 * length(wo + g.wi));
    }
    return radiance;
}

// Returns the specular term of one of several classes from `count` probes, 3 or 5, and one lookup for the grazing part of the lobe.
SpecularTerm class_specular(Surface surface, vec3 wo, const vec3 S, const int count) {
    ProbeSums sums = NO_PROBES;
    bool fitted = is_fitted(surface.fit);
    ProbedLobe lobe = probed_lobe(surface, wo, S, probe_kernel(count));
    for (int i = 0; i < count; ++i) {
        add_probe(sums, surface, wo, lobe, few_node(lobe.probes, wo, count, i), fitted);
    }
    if (SHADOWING != LEADR_SHADOWING_NONE && is_class(surface) && !fitted) {
        sums.by_angle = class_grazing(surface, wo, S);
    }
    return probes_specular(sums, surface, lobe, fitted);
}

// Returns the specular term from random visible directions. The mean of this term over the samples of the reference converges to the
// integral.
SpecularTerm drawn_specular(const Surface surface, const vec3 wo, const vec3 S) {
    vec2 m = surface.mean_slope;
    DirectionArea o = direction_area(wo, m, slope_cholesky(S));
    uint seed = draw_seed(surface.pixel, lighting.draws.y, 0u);
    vec3 reflected = vec3(0.0), fresnel = vec3(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        vec2 u = drawn_point(lighting.draws.x * uint(SAMPLES) + uint(i), seed);
        DrawnReflection d = drawn_reflection(wo, u, m, S, o.visible);
        vec3 f = fresnel_of(surface, d.cosine);
        float variance = drawn_solid_angle(d.density, SAMPLES) / (4.0 * LEADR_PI); // variance per axis of a disc of constant density
        float lit = lit_fraction(FACET_SHADOWING, o, area_for(FACET_SHADOWING, d.wi, m, S, slope_cholesky(S)))
                  * relief_visibility(surface, d.wi, sqrt(variance));
        if (COATED && surface.under_coat) {
            f *= passed_coat(surface, d.wi, d.cosine);
        }
        reflected += f * lit * lobe_radiance(surface, d.wi, variance);
        fresnel += diffuse_fresnel_of(surface, d.cosine);
    }
    return SpecularTerm(reflected / float(SAMPLES), fresnel / float(SAMPLES), o.visible);
}

// Returns the specular term of measured facets from random directions.
SpecularTerm drawn_facets(const Surface surface, const FittedFacet facet) {
    uint seed = draw_seed(surface.pixel, lighting.draws.y, 0u);
    vec3 reflected = vec3(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        vec3 wi = fitted_direction_drawn(facet, drawn_point(lighting.draws.x * uint(SAMPLES) + uint(i), seed));
        float density = fitted_density(facet, wi);
        float variance = drawn_solid_angle(density, SAMPLES) / (4.0 * LEADR_PI);
        float lit = relief_visibility(surface, wi, sqrt(variance));
        vec3 part = fitted_reflected(facet, wi) * (lit / max(density, 1e-9));
        if (COATED && surface.under_coat) {
            part *= passed_coat(surface, wi, 0.5 * length(surface.wo + wi));
        }
        reflected += part * lobe_radiance(surface, wi, variance);
    }
    return SpecularTerm(reflected / float(SAMPLES), vec3(0.0), 1.0);
}

// Returns the specular term of Gaussian slopes. probes is the number of probes per lobe, where probes are used.
SpecularTerm gaussian_specular(const Surface surface, const vec3 wo, const vec3 S, const int probes) {
    if (DRAWN_SPECULAR) {
        return drawn_specular(surface, wo, S);
    }
    if (VISIBLE_SLOPES) {
        return probe_specular(surface, wo, S, probes);
    }
    return grid_specular(surface, wo, S);
}

// Returns the specular term of a GGX base, which is a mixture of Gaussian lobes, each weighted by its visible area.
SpecularTerm ggx_specular(const Surface surface, const vec3 wo, const DisplacedGgx d) {
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    for (int k = 0; k < LEADR_GGX_LOBES; ++k) {
        GaussianLobe lobe = ggx_lobe(d, k);
        if (lobe.weight > 0.0) {
            SpecularTerm part = gaussian_specular(surface, wo, lobe.S, PROBES_OF_LOBE);
            float weight = lobe.weight * part.area;
            sum.reflected += weight * part.reflected;
            sum.fresnel += weight * part.fresnel;
            sum.area += weight;
        }
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    return SpecularTerm(sum.reflected * scale, sum.fresnel * scale, sum.area);
}

// The number of probes of each lobe of Phong facets, which have two.
const int PHONG_PROBES = 9;

// Returns the specular term of Phong facets, which are a mixture of Gaussian lobes, each weighted by its visible area.
SpecularTerm phong_specular(const Surface surface, const vec3 wo, const vec3 C) {
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    for (int k = 0; k < LEADR_PHONG_LOBES; ++k) {
        GaussianLobe lobe = phong_lobe(C, k);
        SpecularTerm part = gaussian_specular(surface, wo, lobe.S, min(SAMPLES, PHONG_PROBES));
        float weight = lobe.weight * part.area;
        sum.reflected += weight * part.reflected;
        sum.fresnel += weight * part.fresnel;
        sum.area += weight;
    }
    float scale = 1.0 / max(sum.area, 1e-12);
    return SpecularTerm(sum.reflected * scale, sum.fresnel * scale, sum.area);
}

// Returns the mean Fresnel reflectance over the diffuse base, for a specular covariance S.
vec3 diffuse_fresnel(const Surface surface, const vec3 wo, const vec3 S) {
    vec2 m = surface.mean_slope;
    if (V_GROOVES) {
        return grid_specular(surface, wo, S).fresnel;
    }
    vec3 f0 = surface.diffuse_f0;
    if (MAPPED) {
        MappedSlopes mapped = mapped_slopes(wo, m, surface.slope_covariance, S);
        return EXACT_FRESNEL ? mapped_fresnel_exact(mapped, f0, surface.diffuse_index) : mapped_fresnel(mapped, f0);
    }
    return EXACT_FRESNEL ? visible_fresnel_exact(wo, m, S, f0, surface.diffuse_index) : visible_fresnel(wo, m, S, f0);
}

// Returns only the mean Fresnel reflectance, without an environment.
vec3 ggx_fresnel(const Surface surface, const vec3 wo, const DisplacedGgx d) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < LEADR_GGX_LOBES; ++k) {
        GaussianLobe lobe = ggx_lobe(d, k);
        float area = MAPPED || V_GROOVES ? 1.0 : visible_area(wo, surface.mean_slope, lobe.S);
        sum += lobe.weight * area * vec4(diffuse_fresnel(surface, wo, lobe.S), 1.0);
    }
    return sum.rgb / max(sum.w, 1e-12);
}

// Returns the same for Phong facets.
vec3 phong_fresnel(const Surface surface, const vec3 wo, const vec3 C) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < LEADR_PHONG_LOBES; ++k) {
        GaussianLobe lobe = phong_lobe(C, k);
        float area = MAPPED || V_GROOVES ? 1.0 : visible_area(wo, surface.mean_slope, lobe.S);
        sum += lobe.weight * area * vec4(diffuse_fresnel(surface, wo, lobe.S), 1.0);
    }
    return sum.rgb / max(sum.w, 1e-12);
}

// Returns the diffuse radiance of the environment per unit of albedo.
vec3 diffuse_environment(const Surface surface, const NormalMoments normals) {
    vec3 c[9] = environment_sh();
    vec3 whole;
    float open = 1.0; // fraction of the light that the facets do not shadow
    if (BY_CLASS && SHADOWING != LEADR_SHADOWING_NONE) {
        whole = surface.sky_light.rgb;
        open = surface.sky_light.a;
    } else if (FACET_SHADOWING == LEADR_SHADOWING_CORRELATED) {
        BentNormal bent = bent_normal(surface.wo, surface.mean_slope, surface.slope_covariance);
        whole = shadowed_diffuse_environment(bent, surface.frame, c, rest_irradiance(surface, bent.normal));
        open = bent.open;
    } else {
        vec3 rest = rest_irradiance(surface, normals.mean) * sh_rest_damping(normals.mean);
        whole = leadr_diffuse_environment(normals, surface.frame, c, rest);
    }
    if (!HAS_HORIZON) {
        return max(whole, 0.0);
    }
    vec2 m = surface.mean_slope;
    return diffuse_past_horizon(whole, open, horizon_hidden(m, surface.horizon), m, surface.frame, c);
}

// Returns the fraction of the environment's specular light that a cone lets through.
float specular_in_cone(const Surface surface) {
    vec3 S = add_roughness(surface.slope_covariance, surface.alpha);
    return cone_specular_share(surface, sqrt(2.0 * normal_variance(surface.mean_slope, S)));
}

// Returns the diffuse radiance per unit of albedo, from an unshadowed light of unit irradiance.
float diffuse_light(const Surface surface, const vec3 wo, const NormalMoments normals, const vec2 faced, const float lambda,
                    const vec3 wi) {
    vec3 S = surface.slope_covariance;
    if (V_GROOVES) {
        return groove_diffuse_light(wo, wi, faced, S, SAMPLES, lambda);
    }
    if (MAPPED && !LIGHTS_BY_SH) {
        return mapped_diffuse_light(wi, surface.mean_slope, S, DIFFUSE_TERMS);
    }
    if (LIGHTS_BY_SH) {
        return leadr_diffuse_light_sh(normals, wo, wi, faced, S, false);
    }
    if (!VISIBLE_SLOPES && GRID_NODES != LEADR_NODES_GRID) {
        return node_diffuse_light(GRID_NODES, wo, wi, surface.mean_slope, S, false, SAMPLES);
    }
    return VISIBLE_SLOPES ? leadr_diffuse_light_visible(wo, wi, surface.mean_slope, S, false, DIFFUSE_TERMS)
                          : leadr_diffuse_light(wo, wi, faced, S, false, SAMPLES, lambda);
}

// Returns the light reflected by measured facets, per unit of irradiance. If the light has a size, one of its directions is drawn.
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

// The roughness and the weight of each base that shares the surface. All weights sum to one. A measured material has one base per lobe.
const int BASES = FIT_LOBES > 1 ? FIT_LOBES : 1;
const int MOST_BASES = 4;

void bases_of(const Surface surface, out vec2 bases[MOST_BASES]) {
    for (int i = 0; i < MOST_BASES; ++i) {
        bases[i] = vec2(surface.alpha, i == 0 ? 1.0 : 0.0);
    }
    if (is_fitted(surface.fit) && GGX_BASE) {
        bases[0].x = min(fit_stretch(surface.fit, surface.alpha) * fitted_ggx_alpha(surface.fit), 2.0);
    } else if (is_fitted(surface.fit)) {
        // Lobes are weighted by the area of their visible facets.
        float stretch = fit_stretch(surface.fit, surface.alpha), all = 0.0;
        int lobes = fitted_lobes(surface.fit);
        for (int i = 0; i < MOST_BASES; ++i) {
            FittedLobe lobe = fitted_lobe(surface.fit, min(i, lobes - 1), stretch);
            float area = MAPPED || V_GROOVES ? 1.0 : visible_area(surface.wo, surface.mean_slope, add_roughness(surface.slope_covariance, lobe.alpha));
            bases[i] = vec2(lobe.alpha, i < lobes ? lobe.share * area : 0.0);
            all += bases[i].y;
        }
        for (int i = 0; i < MOST_BASES; ++i) {
            bases[i].y /= max(all, 1e-12);
        }
    }
}

// The specular lobe of a base with one roughness on the relief.
struct Base {
    float alpha;
    vec3 S;           // covariance of the specular lobe, or of Phong facets
    DisplacedGgx ggx; // replaces S for a GGX base
    vec3 cholesky;
    DirectionArea o;  // visible area for the viewer
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
    if (any_on_diffuse() || any_in_specular()) {
        base.cholesky = slope_cholesky(GGX_BASE ? 0.5 * base.ggx.roughness : PHONG_FACETS ? phong_masking(base.S) : base.S);
        base.o = GGX_BASE       ? displaced_ggx_area(wo, m, base.ggx, base.cholesky)
                 : PHONG_FACETS ? phong_area(wo, m, base.S, base.cholesky)
                                : area_for(FACET_SHADOWING, wo, m, base.S, base.cholesky);
    }
    return base;
}

// Returns the specular radiance of a light, per unit of irradiance. The size of the light widens the lobe. o is the visible area for the
// viewer.
vec3 sized_light(const Surface surface, const DirectionArea o, const Light light, const vec3 S, const DisplacedGgx ggx,
                 const vec3 cholesky) {
    vec3 size = light_slope_covariance(surface.wo, light.wi, light.variance);
    vec2 m = surface.mean_slope;
    if (MAPPED && !GGX_BASE) {
        return mapped_specular_light(surface.wo, light.wi, m, clamp_covariance(S + size), surface.f0);
    }
    if (!GGX_BASE) {
        DirectionArea i = area_for(FACET_SHADOWING, light.wi, m, S, cholesky);
        return leadr_specular_light(FACET_SHADOWING, o, i, surface.wo, light.wi, m, clamp_covariance(S + size), surface.f0);
    }
    vec3 h = surface.wo + light.wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float lit = MAPPED ? 1.0 / max(half_facet_area(surface.wo, light.wi, wh), LEADR_MIN_AREA)
                       : masking_shadowing_factor(FACET_SHADOWING, o, displaced_ggx_area(light.wi, m, ggx, cholesky));
    DisplacedGgx wider = DisplacedGgx(ggx.weight, 2.0 * clamp_covariance(0.5 * ggx.roughness + size));
    return fresnel_schlick(surface.f0, dot(light.wi, wh)) * (0.25 * displaced_ggx_ndf(wh, m, wider) * lit);
}

// Returns the specular radiance of a light in V-grooves, per unit of irradiance.
vec3 groove_light(const Surface surface, const Base base, const Light light) {
    vec3 size = light_slope_covariance(surface.wo, light.wi, light.variance);
    vec3 h = surface.wo + light.wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    vec2 m = face_viewer(surface.wo, surface.mean_slope, base.S, grid_lambda(SAMPLES));
    DisplacedGgx wider = DisplacedGgx(base.ggx.weight, 2.0 * clamp_covariance(0.5 * base.ggx.roughness + size));
    vec3 S = clamp_covariance(base.S + size);
    float d = GGX_BASE ? displaced_ggx_ndf(wh, m, wider) : PHONG_FACETS ? phong_ndf(wh, m, S) : beckmann_ndf(wh, m, S);
    float ao = max(meso_area(surface.wo, m), LEADR_MIN_AREA), ai = max(meso_area(light.wi, m), 0.0);
    return fresnel_schlick(surface.f0, dot(light.wi, wh)) * (0.25 * d * groove_factor(half_facet_area(surface.wo, light.wi, wh), ao, ai));
}

// Returns the specular radiance of a light on Phong facets, per unit of irradiance.
vec3 phong_light(const Surface surface, const Base base, const Light light) {
    vec2 m = surface.mean_slope;
    vec3 size = light_slope_covariance(surface.wo, light.wi, light.variance);
    vec3 h = surface.wo + light.wi;
    vec3 wh = h * inversesqrt(max(dot(h, h), 1e-20));
    float lit = MAPPED ? 1.0 / max(half_facet_area(surface.wo, light.wi, wh), LEADR_MIN_AREA)
                       : masking_shadowing_factor(FACET_SHADOWING, base.o, phong_area(light.wi, m, base.S, base.cholesky));
    return fresnel_schlick(surface.f0, dot(light.wi, wh)) * (0.25 * phong_ndf(wh, m, clamp_covariance(base.S + size)) * lit);
}

// Returns the base's specular reflection of the environment.
SpecularTerm environment_specular(const Surface surface, const Base base) {
    if (GGX_BASE) {
        return ggx_specular(surface, surface.wo, base.ggx);
    }
    if (PHONG_FACETS) {
        return phong_specular(surface, surface.wo, base.S);
    }
    if ((BY_CLASS || CLASSES > 2) && VISIBLE_SLOPES && !DRAWN_SPECULAR) {
        return class_specular(surface, surface.wo, base.S, shaded_class.probes);
    }
    return gaussian_specular(surface, surface.wo, base.S, VISIBLE_SLOPES && CLASSES > 1 ? min(SAMPLES, MOST_CLASS_PROBES) : SAMPLES);
}

// Returns only the mean Fresnel reflectance, for the diffuse base.
vec3 mean_fresnel(const Surface surface, const Base base) {
    if (PHONG_FACETS) {
        return phong_fresnel(surface, surface.wo, base.S);
    }
    return GGX_BASE ? ggx_fresnel(surface, surface.wo, base.ggx) : diffuse_fresnel(surface, surface.wo, base.S);
}

// Returns the base's specular reflection of a light, per unit of irradiance. diffuse_o, diffuse_i and diffuse_cholesky belong to the relief
// without its base.
vec3 specular_of_light(const Surface surface, const Base base, const int number, const Light light, const DirectionArea diffuse_o,
                    const DirectionArea diffuse_i,
                    const vec3 diffuse_cholesky) {
    vec3 wo = surface.wo, f0 = surface.f0;
    vec2 m = surface.mean_slope;
    if (!in_specular(number)) {
        return vec3(0.0);
    }
    if (V_GROOVES) {
        return groove_light(surface, base, light);
    }
    if (FACET_SPECULAR) {
        FacetSpecular specular = facet_specular(wo, light.wi, base.alpha, light.variance);
        return facet_specular_light(FACET_SHADOWING, SHADOWING, diffuse_o, diffuse_i, specular, m, diffuse_cholesky, f0);
    }
    if (PHONG_FACETS) {
        return phong_light(surface, base, Light(light.wi, light.irradiance, of_panorama(number) ? light.variance : 0.0, 0.0));
    }
    if (of_panorama(number)) {
        return sized_light(surface, base.o, light, base.S, base.ggx, base.cholesky);
    }
    if (MAPPED && GGX_BASE) {
        return sized_light(surface, base.o, Light(light.wi, light.irradiance, 0.0, 0.0), base.S, base.ggx, base.cholesky);
    }
    if (GGX_BASE) {
        return displaced_ggx_light(FACET_SHADOWING, base.o, wo, light.wi, m, base.ggx, base.cholesky, f0);
    }
    if (MAPPED) {
        return mapped_specular_light(wo, light.wi, m, base.S, f0);
    }
    if (FACET_SHADOWING == LEADR_SHADOWING_NONE) {
        return leadr_specular_directional(wo, light.wi, m, base.S, f0, false);
    }
    DirectionArea i = area_for(FACET_SHADOWING, light.wi, m, base.S, base.cholesky);
    return leadr_specular_light(FACET_SHADOWING, base.o, i, wo, light.wi, m, base.S, f0);
}

// Returns the same, with the pixel kernel of the light where lights have kernels of their own.
vec3 specular_light(Surface surface, Base base, const int number, const Light light, DirectionArea diffuse_o, DirectionArea diffuse_i,
                    vec3 diffuse_cholesky) {
    if (PER_LIGHT_KERNEL && in_specular(number)) {
        vec3 kernel = light_kernel(surface, light);
        surface.slope_covariance = GGX_BASE ? surface.sharp : filter_covariance(surface.sharp, kernel);
        base = base_of(surface, base.alpha);
        if (GGX_BASE) {
            base.ggx = displaced_ggx(filter_roughness(vec3(vec2(base.alpha * base.alpha), 0.0), kernel), surface.sharp);
            base.cholesky = slope_cholesky(0.5 * base.ggx.roughness);
            base.o = displaced_ggx_area(surface.wo, surface.mean_slope, base.ggx, base.cholesky);
        }
        diffuse_cholesky = slope_cholesky(surface.slope_covariance);
        // Masking belongs to the same facets. At grazing views, the areas of narrower lobes are too small for the wide ones.
        diffuse_o = area_for(FACET_SHADOWING, surface.wo, surface.mean_slope, surface.slope_covariance, diffuse_cholesky);
        diffuse_i = area_for(FACET_SHADOWING, light.wi, surface.mean_slope, surface.slope_covariance, diffuse_cholesky);
    }
    return specular_of_light(surface, base, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
}

// Passes for all kinds of surfaces also shade single lobes in the loop over measured lobes, because software drivers run both sides of
// every branch. Each iteration evaluates the nodes of one lobe's rule, or a part of a single rule with SAMPLES nodes.
const bool SHARES_PROBES = FIT_LOBES > 1 && VISIBLE_SLOPES && !DRAWN_SPECULAR;
const int LOBE_NODES = FIT_LOBES == 2 ? 9 : FIT_LOBES == 3 ? 6 : 5;
const int LOBE_RULE = FIT_LOBES == 2 ? 9 : PROBES_OF_LOBE;
const int SPREAD_NODES = FIT_LOBES == 2 ? (SAMPLES + 1) / 2 : FIT_LOBES == 3 ? (SAMPLES + 2) / 3 : (SAMPLES + 3) / 4;

// Returns the environment in the lobes of measured materials, each with its own rule, and in bases of one lobe.
SpecularTerm shared_probes(Surface surface, const vec2 bases[MOST_BASES]) {
    vec3 wo = surface.wo;
    bool fitted = is_fitted(surface.fit);
    vec3 kernel = fitted ? probe_kernel(LOBE_RULE) : probe_kernel(SAMPLES);
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    ProbeSums sums = NO_PROBES;
    for (int i = 0; i < FIT_LOBES; ++i) {
        ProbedLobe lobe = probed_lobe(surface, wo, base_of(surface, bases[fitted ? i : 0].x).S, kernel);
        [[unroll]] for (int j = 0; j < LOBE_NODES; ++j) {
            int spread = i * SPREAD_NODES + j;
            ProbeNode node = probe_node(LOBE_RULE, min(j, LOBE_RULE - 1), lobe.probes.wide);
            bool counts = j < LOBE_RULE;
            if (!fitted) {
                node = probe_node(SAMPLES, min(spread, SAMPLES - 1), lobe.probes.wide);
                counts = j < SPREAD_NODES && spread < SAMPLES;
            }
            node.weight = counts ? node.weight : 0.0;
            add_probe(sums, surface, wo, lobe, node, fitted);
        }
        if (fitted || i == FIT_LOBES - 1) {
            SpecularTerm part = probes_specular(sums, surface, lobe, fitted);
            float weight = fitted ? bases[i].y : 1.0;
            sum.reflected += weight * part.reflected;
            sum.fresnel += weight * part.fresnel;
            sums = NO_PROBES;
        }
    }
    return sum;
}

// Returns the environment reflected by all bases.
SpecularTerm specular_of(const Surface surface, const vec2 bases[MOST_BASES]) {
    if (SHARES_PROBES) {
        return shared_probes(surface, bases);
    }
    SpecularTerm sum = SpecularTerm(vec3(0.0), vec3(0.0), 0.0);
    if (BASES > 2) {
        for (int i = 0; i < BASES; ++i) {
            SpecularTerm part = environment_specular(surface, base_of(surface, bases[i].x));
            sum.reflected += bases[i].y * part.reflected;
            sum.fresnel += bases[i].y * part.fresnel;
        }
        return sum;
    }
    // One or two bases are unrolled, which is faster. With more bases, drivers would compile for ten seconds.
    [[unroll]] for (int i = 0; i < min(BASES, 2); ++i) {
        SpecularTerm part = environment_specular(surface, base_of(surface, bases[i].x));
        sum.reflected += bases[i].y * part.reflected;
        sum.fresnel += bases[i].y * part.fresnel;
    }
    return sum;
}

// Returns the mean Fresnel reflectance of all bases over the diffuse base.
vec3 fresnel_under(const Surface surface, const vec2 bases[MOST_BASES]) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < BASES; ++i) {
        sum += bases[i].y * mean_fresnel(surface, base_of(surface, bases[i].x));
    }
    return sum;
}

// Returns the mean Fresnel reflectance over the diffuse base without relief, as for a single bounce.
vec3 smooth_fresnel(Surface surface, const Bounces bounces) {
    surface.mean_slope = vec2(0.0);
    surface.slope_covariance = vec3(0.0);
    surface.wo = bounces.wo;
    return mean_fresnel(surface, base_of(surface, bounces.alpha));
}

// Returns the specular reflection of a light by all bases, per unit of irradiance. The arguments are those of specular_light.
vec3 light_in_specular(const Surface surface, const vec2 bases[MOST_BASES], const int number, const Light light,
                       const DirectionArea diffuse_o, const DirectionArea diffuse_i,
                      const vec3 diffuse_cholesky) {
    vec3 sum = vec3(0.0);
    if (BASES > 2) {
        for (int i = 0; i < BASES; ++i) {
            if (bases[i].y > 0.0) {
                Base base = base_of(surface, bases[i].x);
                sum += bases[i].y * specular_light(surface, base, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
            }
        }
    } else {
        [[unroll]] for (int i = 0; i < min(BASES, 2); ++i) {
            Base base = base_of(surface, bases[i].x);
            sum += bases[i].y * specular_light(surface, base, number, light, diffuse_o, diffuse_i, diffuse_cholesky);
        }
    }
    return sum * fresnel_over_schlick(surface.fit, surface.f0, surface.edge_tint, surface.index, 0.5 * length(surface.wo + light.wi));
}

#include "coat.glsl"
#include "transmission.glsl"

// The values of a surface that all its lights share. They belong to the relief without its base.
struct Reflection {
    bool exact;           // whether one facet of a measured material is lit
    vec3 entering;        // fraction of light that enters the diffuse base
    NormalMoments normals;
    vec2 faced;
    float lambda;
    vec3 cholesky;
    DirectionArea o;      // visible area for the viewer
};

// Returns the light `number` that the surface reflects.
vec3 light_reflected(const int number, const Light light, const Surface surface, const vec2 bases[MOST_BASES], const Bounces bounces,
                     const FittedFacet facet, const Reflection r, const CoatLayer coat) {
    vec3 scattered = vec3(0.0);
    DirectionArea diffuse_i;
    if (on_diffuse(number) || (FACET_SPECULAR && in_specular(number))) {
        diffuse_i = area_for(FACET_SHADOWING, light.wi, surface.mean_slope, surface.slope_covariance, r.cholesky);
    }
    if (on_diffuse(number)) {
        float lit = lit_fraction(FACET_SHADOWING, r.o, diffuse_i);
        scattered += r.entering * surface.albedo * (lit * diffuse_light(surface, surface.wo, r.normals, r.faced, r.lambda, light.wi));
        if (!LAMBERTIAN) {
            scattered *= bounced_light(bounces, surface, surface.albedo, light.wi);
        }
    }
    vec3 specular = vec3(0.0);
    if (FINEST_LEVEL && r.exact) {
        specular = in_specular(number) ? facet_light(surface, facet, number, light) : vec3(0.0);
    } else {
        specular = light_in_specular(surface, bases, number, light, r.o, diffuse_i, r.cholesky);
        if (SCALES_SPECULAR) {
            specular *= bounces.specular;
        }
    }
    if (COATED) {
        vec3 over_diffuse, over_specular;
        coat_over_light(coat, surface, light.wi, over_diffuse, over_specular);
        scattered *= over_diffuse;
        specular *= over_specular;
    }
    return light.irradiance * (scattered + specular);
}

vec3 leadr_radiance(Surface surface) {
    if (PER_LIGHT_KERNEL) {
        surface.sharp = surface.slope_covariance;
        surface.slope_covariance = with_normal_kernel(surface);
    }
    vec3 wo = surface.wo;
    Medium medium = NO_MEDIUM;
    vec3 passed_color = vec3(0.0);
    if (TRANSMITS) {
        medium = medium_of(surface.medium);
        passed_color = medium.weight * surface.albedo;
        surface.albedo *= 1.0 - medium.weight;
    }
    vec2 m = surface.mean_slope;
    vec3 diffuse_s = surface.slope_covariance;
    // Each base that shares the surface has its own specular lobe.
    vec2 bases[MOST_BASES];
    bases_of(surface, bases);
    bool exact = FINEST_LEVEL && is_fitted(surface.fit);
    Bounces bounces;
    if (!LAMBERTIAN) {
        // One facet stands for all visible facets of the relief. At the mean normal, the error is up to ten times as large.
        vec2 slope = MAPPED ? mapped_slopes(wo, m, diffuse_s, diffuse_s).slopes.mean : visible_slopes(wo, m, diffuse_s).mean;
        bounces = bounces_of(surface, slope, surface.alpha);
    }
    FittedFacet facet;
    if (exact) {
        vec2 u = drawn_point(lighting.draws.x, draw_seed(surface.pixel, lighting.draws.y, FACET_DRAW));
        vec3 normal = fitted_normal(surface.fit, wo, m, diffuse_s, MAPPED, u);
        facet = fitted_facet(surface.fit, surface.alpha, wo, normal, diffuse_s);
    }
    vec3 radiance = vec3(0.0);
    CoatLayer coat;
    if (COATED) {
        coat = coat_over(surface);
        float outward = coat.outward;
        if (SPECULAR_ENVIRONMENT) {
            SpecularTerm reflected = environment_specular(coat.surface, coat.base);
            radiance += surface.coat.weight * ambient_in_specular(coat.surface) * specular_in_cone(coat.surface) * reflected.reflected;
            outward = surface.coat.weight * reflected.fresnel.x;
        }
        set_outward(coat, outward);
        surface.under_coat = true;
    }

    // Only light that the specular term does not reflect enters the surface and reaches the diffuse base.
    vec3 entering = vec3(1.0);
    if (SPECULAR_ENVIRONMENT) {
        SpecularTerm specular;
        if (exact) {
            specular = drawn_facets(surface, facet);
        } else {
            specular = specular_of(surface, bases);
        }
        if (SCALES_SPECULAR) {
            specular.reflected *= bounces.specular;
        }
        if (COATED) {
            specular.reflected *= 1.0 - coat.outward;
        }
        radiance += ambient_in_specular(surface) * specular_in_cone(surface) * specular.reflected;
        entering = 1.0 - specular.fresnel;
    } else if (DIFFUSE && !exact) {
        entering = 1.0 - fresnel_under(surface, bases);
    }
    if (MULTISCATTERING && DIFFUSE && !exact) {
        entering *= bounces.entered / max(1.0 - smooth_fresnel(surface, bounces), vec3(1e-3));
    }
    // Diffuse models do not change the light that passes through the surface.
    vec3 passing = entering;
    if (!LAMBERTIAN && !MULTISCATTERING) {
        entering = (COAT_IN_MODEL ? vec3(1.0) : entering) * bounces.albedo;
    }

    if (TRANSMITS && (SPECULAR_ENVIRONMENT || any_in_specular())) {
        vec3 enters = SPECULAR_ENVIRONMENT || DIFFUSE ? passing : 1.0 - fresnel_under(surface, bases);
        vec3 behind = passed_color * transmitted(surface, medium, base_of(surface, surface.alpha), enters);
        radiance += COATED ? (1.0 - coat.outward) * behind : behind;
    }

    vec3 diffuse_cholesky = slope_cholesky(diffuse_s);
    DirectionArea diffuse_o = area_for(FACET_SHADOWING, wo, m, diffuse_s, diffuse_cholesky);
    float lambda = grid_lambda(SAMPLES);
    vec2 faced = face_viewer(wo, m, diffuse_s, lambda);
    NormalMoments normals;
    if ((DIFFUSE_ENVIRONMENT && FACET_SHADOWING != LEADR_SHADOWING_CORRELATED) || (any_on_diffuse() && LIGHTS_BY_SH)) {
        normals = MAPPED ? mapped_diffuse_moments(m, diffuse_s, DIFFUSE_TERMS)
                : V_GROOVES      ? groove_normal_moments(wo, faced, diffuse_s, SAMPLES, lambda)
                : VISIBLE_SLOPES ? visible_diffuse_moments(wo, m, diffuse_s, DIFFUSE_TERMS)
                : GRID_NODES != LEADR_NODES_GRID ? node_normal_moments(GRID_NODES, wo, m, diffuse_s, SAMPLES)
                                 : visible_normal_moments(wo, faced, diffuse_s, SAMPLES, lambda);
    }
    if (DIFFUSE_ENVIRONMENT) {
        vec3 albedo = surface.albedo;
        vec3 ambient = ambient_on_diffuse(surface, albedo) * cone_diffuse(surface, albedo, environment_sh());
        if (COATED) {
            ambient *= coat_over_diffuse(coat, albedo);
        }
        radiance += entering * albedo * ambient * diffuse_environment(surface, normals);
    }
    if (INTERREFLECTION && DIFFUSE) {
        vec3 from_relief = entering * surface.albedo * relief_seen(surface, surface.larger) * surface.relief_radiance;
        radiance += COATED ? coat_over_diffuse(coat, surface.albedo) * from_relief : from_relief;
    }
    if (any_on_diffuse() || any_in_specular()) {
        Reflection r = Reflection(exact, entering, normals, faced, lambda, diffuse_cholesky, diffuse_o);
        [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
            Light light;
            if (CLASSES > 1 || INTERREFLECTION) {
                light = pixel_lights[number];
                light.irradiance *= BY_CLASS
                    ? class_lit_by(surface, light.wi, pixel_lights_depths[number], pixel_lights_passed[number]) : 1.0;
            } else {
                light = light_at(number, surface);
            }
            radiance += light_reflected(number, light, surface, bases, bounces, facet, r, coat);
            if (COATED) {
                radiance += coat_light(coat, number, surface.coat.own ? light_at(number, coat.surface) : light);
            }
        }
        if (MORE_LAMPS) {
            Light light;
            float passed;
            for (int lamp = next_lamp(LAMPS, surface, light, passed); lamp < lamp_count(surface.wo.z);
                 lamp = next_lamp(lamp + 1, surface, light, passed)) {
                if (BY_CLASS) {
                    light.irradiance *= class_lit_by(surface, light.wi, depths_towards(light.wi), passed);
                }
                radiance += light_reflected(ANY_LAMP, light, surface, bases, bounces, facet, r, coat);
                if (COATED) {
                    radiance += coat_light(coat, ANY_LAMP, surface.coat.own ? lamp_sent(lamps[lamp], coat.surface) : light);
                }
            }
        }
    }
    return radiance;
}

// The smallest share of the visible area with which a class is shaded.
const float LEAST_SEEN = 1.0 / 256.0;

// Returns the radiance of all classes of facets, each weighted by its visible share.
vec3 classes_radiance(Surface surface) {
    vec4 seen = classes_seen(surface);
    [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
        pixel_lights_depths[number] = BY_CLASS ? depths_towards(pixel_lights[number].wi) : vec4(0.0);
    }
    const bool sees_sky = BY_CLASS && SHADOWING != LEADR_SHADOWING_NONE && (DIFFUSE_ENVIRONMENT || INTERREFLECTION);
    if (sees_sky) {
        light_by_sky(surface, seen);
    }
    // The numbers of the visible classes, with two bits each, from the largest.
    int largest = 0;
    float most = seen[0];
    [[unroll]] for (int k = 1; k < CLASSES; ++k) {
        largest = seen[k] > most ? k : largest;
        most = max(most, seen[k]);
    }
    uint numbers = uint(largest);
    int count = 1;
    float whole = most;
    [[unroll]] for (int k = 0; k < CLASSES; ++k) {
        if (seen[k] > LEAST_SEEN && k != largest) {
            numbers |= uint(k) << (2 * count);
            whole += seen[k];
            ++count;
        }
    }
    vec3 sum = vec3(0.0);
    for (int i = 0; i < count; ++i) {
        int k = int(numbers >> (2 * i)) & 3;
        Surface part = class_part(surface, k, i == 0 ? MOST_CLASS_PROBES : FEWEST_PROBES);
        if (sees_sky) {
            part.sky_light = pixel_sky[k];
        }
        sum += seen[k] * leadr_radiance(part);
    }
    return sum / max(whole, 1e-6);
}

// Returns the radiance of a surface, by classes of facets where it has several.
vec3 relief_shaded(Surface surface) {
    surface.whole_mean = surface.mean_slope;
    if (BY_CLASS) {
        // The openness of the classes accounts for the bumps inside the footprint, or for all bumps.
        surface.horizon = LOCAL_OPENNESS ? Horizon(vec2(0.0), vec3(0.0)) : raised_horizon(surface.horizon, 1.0 - pixel_classes.inside);
    }
    if (CLASSES > 1 || INTERREFLECTION) {
        [[unroll]] for (int number = 0; number < LIGHTS; ++number) {
            pixel_lights[number] = light_sent(number, surface);
            pixel_lights_passed[number] = light_passed(number, surface, pixel_lights[number]);
            pixel_lights[number].irradiance *= pixel_lights_passed[number];
        }
    }
    if (INTERREFLECTION) {
        surface.larger = hidden_by_horizon(surface);
        surface.relief_radiance = relief_radiance(surface, surface.larger);
    }
    if (CLASSES > 1) {
        return classes_radiance(surface);
    }
    return leadr_radiance(surface);
}

#endif
