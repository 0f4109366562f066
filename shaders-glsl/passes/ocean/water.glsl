// What the sea's filters leave of the water in the G-buffer, beside its slopes.
#ifndef LEADR_OCEAN_WATER
#define LEADR_OCEAN_WATER

layout(binding = 5, std140) uniform Water {
    vec4 centre;   // of the rest positions, world xy; z: 1 / radius of the earth
    vec4 tail;     // slope covariance xx, yy, xy of the waves below the cascades; w: roughness of the water itself
    vec4 color;    // diffuse albedo of the water; w: reflectance at normal incidence
    vec4 foam;     // albedo; w: det J below which the sea foams
} water;

layout(location = 0) out vec4 out_frame;
layout(location = 1) out vec4 out_covariance;
layout(location = 2) out vec4 out_material;
layout(location = 3) out vec4 out_surface;

// covered: part of the surface that is foam; lod: of the maps.
void write_water(vec2 mean, vec3 covariance, float covered, float lod) {
    out_frame = vec4(octahedral_encode(vec3(0.0, 0.0, 1.0)), mean);
    out_covariance = vec4(covariance, lod);
    out_material = vec4(mix(water.color.rgb, water.foam.rgb, covered), mix(water.tail.w, 0.6, covered));
    out_surface = vec4(water.color.w * (1.0 - covered), 1.0, 0.0, 0.0);
}

#endif
