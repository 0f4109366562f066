// Code shared by the stages that draw the sea (crates/leadr-render/src/passes/ocean/surface.rs).
#ifndef LEADR_OCEAN_SURFACE
#define LEADR_OCEAN_SURFACE
#include "cascade.glsl"
#include "shore.glsl"

layout(std140) uniform View {
    mat4 clip_from_world;
    vec4 window; // xy: size of the image in pixels
    vec4 centre; // point below the camera: world xy, height of the water; w: 1 / (2 radius of the earth)
} view;

struct Vertex {
    vec2 position; // rest position, in world metres
    float spacing; // spacing of the vertices around the position, in metres
    float unused;
};

layout(std430) readonly buffer Vertices { Vertex vertices[]; };
layout(std430) readonly buffer Patches { uvec4 patches[]; };      // vertices at the corners (0,0) (1,0) (1,1) (0,1)
layout(std430) readonly buffer Edges { uvec4 patch_edges[]; };    // sides v=0, u=1, v=1, u=0, as edge << 1 | backwards
layout(std430) readonly buffer EdgeFactors { float edge_factors[]; };
layout(std430) readonly buffer VisiblePatches { uint visible_patches[]; };
layout(std430) readonly buffer Cascades { Cascade cascades[]; };
uniform sampler2DArray displacement;
layout(std140) uniform Beach { Shore shore; };
layout(constant_id = 2) const bool HAS_BEACH = false; // a constant, because a branch on a uniform is slow on CPU drivers

// Returns a rest position displaced by the waves. xy is the rest position, and z is the vertex spacing there. The result depends on the
// position alone, so shared vertices move by the same amount.
vec3 carried(const vec3 rest) {
    int count = textureSize(displacement, 0).z;
    float samples = float(textureSize(displacement, 0).x);
    vec3 moved = vec3(0.0);
    float depth = 0.0;
    if (HAS_BEACH) {
        ShoreWater water = shore_water(shore, rest.xy, 0.5 * rest.z);
        moved.z = water.height;
        depth = water.depth;
    }
    for (int i = 0; i < count; ++i) {
        Cascade c = cascades[i];
        // There are two vertices per sample of the level. The geometry cannot resolve finer waves; the moments account for them.
        float lod = log2(max(rest.z * samples / c.size, 1.0));
        float calm = HAS_BEACH ? shore_calm(shore, i, depth) : 1.0;
        moved += calm * textureLod(displacement, vec3(cascade_texcoord(c, rest.xy), float(i)), lod).xyz;
    }
    vec2 away = rest.xy - view.centre.xy;
    precise vec3 position = vec3(rest.xy + moved.xy, view.centre.z + moved.z - dot(away, away) * view.centre.w);
    return position;
}

#endif
