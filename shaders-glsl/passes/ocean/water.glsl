// What the filters of the sea need to know about the water (`WaterGpu` in src/render/passes/ocean/filter.rs).
#ifndef LEADR_OCEAN_WATER
#define LEADR_OCEAN_WATER

layout(std140) uniform Water {
    vec4 centre;   // of the rest positions, world xy; z: 1 / radius of the earth
    vec4 tail;     // slope covariance xx, yy, xy of the waves below the cascades; w: roughness of the water itself
    vec4 color;    // diffuse albedo of the water; w: reflectance at normal incidence
    vec4 foam;     // albedo; w: the sea foams where its stretch is below this
} water;

#endif
