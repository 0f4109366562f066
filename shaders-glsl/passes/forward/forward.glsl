#ifndef LEADR_FORWARD
#define LEADR_FORWARD
// A plain forward pass, as a baseline for performance. The pass draws a quad with the fragment shaders of the LEADR paper's supplement
// (section 3). Each map is fetched once, and there is no G-buffer and no tiles. Library functions are used wherever they match the
// supplement.
#include "leadr/frame.glsl"
#include "leadr/facets/fresnel.glsl"
#include "leadr/slopes/grid.glsl"

layout(std140) uniform Forward {
    mat4 clip_from_world;
    vec4 camera_position; // xyz: position of the camera
    vec4 sun_direction;   // xyz: unit vector toward the sun
    vec4 sun_irradiance;  // rgb: irradiance on a plane that faces the sun
    vec4 material;        // rgb: albedo; a: Beckmann roughness
    vec4 surface;         // F0, height scale, texels along an edge of the environment's cube map
    vec4 radiance_sh[9];  // rgb: one coefficient each
} forward;

#endif
