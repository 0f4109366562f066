// What the stages that draw the sea share (render/ocean/surface.rs).
#ifndef LEADR_OCEAN_SURFACE
#define LEADR_OCEAN_SURFACE
#include "cascade.glsl"
#include "shore.glsl"

layout(binding = 0, std140) uniform View {
    mat4 clip_from_world;
    vec4 centre; // below the camera: world xy, height of the water; w: 1 / (2 radius of the earth)
} view;

struct Vertex {
    vec2 position; // at rest, world metres
    float spacing; // of the vertices around it, metres
    float unused;
};

layout(binding = 1, std430) readonly buffer Vertices { Vertex vertices[]; };
layout(binding = 2, std430) readonly buffer Patches { uvec4 patches[]; };      // corners (0,0) (1,0) (1,1) (0,1)
layout(binding = 3, std430) readonly buffer Edges { uvec4 patch_edges[]; };    // sides v=0, u=1, v=1, u=0: edge << 1 | backwards
layout(binding = 4, std430) readonly buffer EdgeFactors { float edge_factors[]; };
layout(binding = 5, std430) readonly buffer VisiblePatches { uint visible_patches[]; };
layout(binding = 6, std430) readonly buffer Cascades { Cascade cascades[]; };
layout(binding = 7) uniform sampler2DArray displacement;
layout(binding = 8, std140) uniform Beach { Shore shore; };

#endif
