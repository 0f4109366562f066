// The water parameters for the filters of the sea (`WaterGpu` in crates/leadr-render/src/passes/ocean/filter.rs).
#ifndef LEADR_OCEAN_WATER
#define LEADR_OCEAN_WATER

#include "../gbuffer.glsl"

layout(std140) uniform Water {
    vec4 centre;   // xy: world position of the centre of the rest positions; z: 1 / radius of the earth
    vec4 tail;     // slope covariance xx, yy, xy of the waves below the finest cascade; w: roughness of the water itself
    vec4 color;    // rgb: diffuse albedo of the water; w: reflectance at normal incidence
    vec4 foam;     // rgb: albedo of the foam; w: stretch below which the sea foams
} water;

// Returns water with these slopes. The displacement direction is up everywhere, and waves do not occlude the surroundings.
FilteredSurface filtered_water(vec2 mean_slope, vec3 covariance, vec4 material, float f0) {
    FilteredSurface f;
    f.normal = vec3(0.0, 0.0, 1.0);
    f.mean_slope = mean_slope;
    f.covariance = covariance;
    f.material = material;
    f.fit = 0u;
    f.f0 = vec3(f0);
    f.diffuse_f0 = f0;
    f.edge_tint = vec3(0.0);
    f.emission = vec3(0.0);
    f.accessibility = 1.0;
    f.inside = false;
    f.horizon = Horizon(vec2(0.0), vec3(0.0));
    f.cone = NO_CONE;
    f.lod = 0.0;
    f.joined = 0.0;
    f.relief = 0.0;
    f.rotation = mat2(0.0);
    f.coat = NO_COAT;
    f.medium = 0u;
    return f;
}

#endif
