// The clear coat of a surface (leadr/visible/clear_coat.glsl), which reflects light like a surface of its own. Included by leadr.glsl.
#ifndef LEADR_SHADE_COAT
#define LEADR_SHADE_COAT

struct CoatLayer {
    Surface surface;   // the relief and the roughness of the coat
    Base base;         // the specular lobe
    vec3 S;            // covariance of the slopes, including the roughness
    vec3 cholesky;     // of the relief without the roughness
    DirectionArea o;   // visible area of this relief
    float outward;     // reflectance toward the viewer
    float ambient;     // reflectance toward the environment that a diffuse base reflects
};

// Returns a direction of the surface's frame in the frame of the coat.
vec3 to_coat(const CoatLayer coat, const Surface surface, const vec3 w) {
    return surface.coat.own ? to_frame(coat.surface.frame, from_frame(surface.frame, w)) : w;
}

// Returns the reflectance of the coat toward a direction of its own frame.
float coat_toward(const CoatLayer coat, const vec3 w) {
    vec2 m = coat.surface.mean_slope;
    float weight = coat.surface.coat.weight;
    if (MAPPED) {
        MappedSlopes mapped = mapped_slopes(w, m, coat.surface.slope_covariance, coat.S);
        vec3 f0 = vec3(LEADR_COAT_F0);
        return weight * (EXACT_FRESNEL ? mapped_fresnel_exact(mapped, f0, LEADR_COAT_INDEX) : mapped_fresnel(mapped, f0)).x;
    }
    return coat_reflectance(w, m, coat.S, weight, EXACT_FRESNEL);
}

// Returns the mean reflectance of the coat over the environment that a facet of normal n receives, in world space.
float coat_toward_environment(const float weight, const vec3 n) {
    vec3 c[9] = environment_sh();
    float whole = dot(max(sh_irradiance(c, n), 0.0), vec3(1.0));
    vec3 bands = coat_bands(weight, EXACT_FRESNEL);
    for (int i = 0; i < 9; ++i) {
        c[i] *= i == 0 ? bands.x : i < 4 ? bands.y : bands.z;
    }
    float reflected = dot(sh_irradiance(c, n), vec3(1.0));
    return whole > 0.0 ? clamp(reflected / whole, LEADR_COAT_F0 * weight, weight) : coat_average(weight, EXACT_FRESNEL);
}

// Returns the coat of a surface. The coat lies above the surface, so a coat with its own relief is not occluded by the relief below.
CoatLayer coat_over(const Surface surface) {
    CoatLayer coat;
    Surface s = surface;
    s.alpha = surface.coat.alpha;
    s.f0 = vec3(LEADR_COAT_F0);
    s.diffuse_f0 = vec3(LEADR_COAT_F0);
    s.edge_tint = vec3(0.0);
    s.index = s.diffuse_index = LEADR_COAT_INDEX;
    s.fit = 0u;
    if (surface.coat.own) {
        s.frame = frame_about(surface.coat_normal);
        s.wo = to_frame(s.frame, from_frame(surface.frame, surface.wo));
        s.mean_slope = surface.coat.mean_slope;
        s.slope_covariance = surface.coat.covariance;
        if (TILTS_TO_EDGE && !NORMAL_MAPPED) {
            vec2 tilt = tilt_to_edge(s.wo, s.mean_slope);
            s.mean_slope += tilt;
            s.slope_covariance += vec3(tilt * tilt, tilt.x * tilt.y);
        }
        s.whole_mean = s.mean_slope;
        s.horizon = Horizon(vec2(0.0), vec3(0.0));
        s.cone = NO_CONE;
        s.relief_radiance = vec3(0.0);
        s.larger = 0.0;
        s.above = true;
    }
    coat.surface = s;
    coat.base = base_of(s, s.alpha);
    coat.S = add_roughness(s.slope_covariance, s.alpha);
    coat.cholesky = slope_cholesky(s.slope_covariance);
    coat.o = area_for(FACET_SHADOWING, s.wo, s.mean_slope, s.slope_covariance, coat.cholesky);
    coat.outward = s.coat.weight * mean_fresnel(s, coat.base).x;
    coat.ambient = coat_average(s.coat.weight, EXACT_FRESNEL);
    return coat;
}

// Sets the reflectance of the coat toward the viewer, and the reflectance of its mean visible facet toward the environment.
void set_outward(inout CoatLayer coat, const float outward) {
    coat.outward = outward;
    if (DIFFUSE_ENVIRONMENT) {
        vec2 facing = MAPPED ? coat.surface.mean_slope : visible_slopes(coat.surface.wo, coat.surface.mean_slope, coat.S).mean;
        coat.ambient = coat_toward_environment(coat.surface.coat.weight, from_frame(coat.surface.frame, normal_of_slope(facing)));
    }
}

// Returns the factor of the coat on the environment that the diffuse base reflects.
vec3 coat_over_diffuse(const CoatLayer coat, const vec3 albedo) {
    return coated_base(coat.outward, coat.ambient, coat_average(coat.surface.coat.weight, EXACT_FRESNEL), albedo);
}

// Returns the factors of the coat on the diffuse and the specular light from wi.
void coat_over_light(const CoatLayer coat, const Surface surface, const vec3 wi, out vec3 diffuse, out vec3 specular) {
    float weight = coat.surface.coat.weight;
    vec3 w = to_coat(coat, surface, wi);
    vec2 both = MAPPED ? vec2(coat.outward, coat_toward(coat, w))
                       : coat_reflectances(coat.surface.wo, w, coat.surface.mean_slope, coat.S, weight, EXACT_FRESNEL);
    diffuse = coated_base(both.x, both.y, coat_average(weight, EXACT_FRESNEL), surface.albedo);
    specular = coated_base(both.x, both.y, both.y, fresnel_of(surface, 0.5 * length(surface.wo + wi)));
}

// Returns the light `number` that the coat reflects. light is in the frame of the coat.
vec3 coat_light(const CoatLayer coat, const int number, const Light light) {
    DirectionArea i = area_for(FACET_SHADOWING, light.wi, coat.surface.mean_slope, coat.surface.slope_covariance, coat.cholesky);
    return coat.surface.coat.weight * light.irradiance * specular_light(coat.surface, coat.base, number, light, coat.o, i, coat.cholesky);
}

#endif
