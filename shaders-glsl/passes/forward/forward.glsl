#ifndef LEADR_FORWARD
#define LEADR_FORWARD
// A plain forward pass, as a baseline for performance: the fragment shaders of the LEADR paper's supplement (section 3) on a
// quad, one fetch of each map, without G-buffer or tiles. Library functions are used wherever they match the supplement.
#include "leadr/frame.glsl"
#include "leadr/facets/fresnel.glsl"
#include "leadr/slopes/grid.glsl"

layout(std140) uniform Forward {
    mat4 clip_from_world;
    vec4 camera_position; // xyz
    vec4 sun_direction;   // xyz toward it
    vec4 sun_irradiance;  // rgb, on a plane that faces it
    vec4 material;        // albedo, Beckmann roughness
    vec4 surface;         // F0, height scale, texels along an edge of the environment's cube
    vec4 radiance_sh[9];  // rgb
} forward;

#endif
