// Data for passes that draw one object at a time: the records of the object and of the view.
#ifndef LEADR_GEOMETRY_OBJECT
#define LEADR_GEOMETRY_OBJECT
#include "../constants.glsl"

struct ObjectRecord {
    vec4 color;         // of a plain object: linear albedo, Beckmann roughness alpha
    vec4 tangent_s;     // of a flat object: tangents by texture coordinate; w: 1, or -1 if clockwise seen from outside
    vec4 tangent_t;     // w: accessibility of a plain object
    vec2 shift;         // of a map tiled without repeats: position of its lattice, in repeats
    float height_scale; // eta of LEADR section 4.2
    float displacement; // the same for the geometry, which may be smooth
    float relief;       // from the deepest pit to the highest bump, metres
    float viewer_above; // of a flat object: height of the viewer above its plane, metres
    float texel_repeat; // metres per repeat of its map, with one vertex per texel centre
    float specular_f0;
    uint flags;         // FLAG_ bits
    uint number;        // in the scene, from 1
    uint fit;           // of its measured material, from 1, or 0
    uint edge_tint;     // F82 tint of a conductor, see unpack_edge_tint
};

struct ViewRecord {
    mat4 clip_from_world;
    vec4 ray_x;       // rays of the image, as in Camera::rays; w: horizontal step from pixel to pixel in ndc
    vec4 ray_y;       // w: vertical step
    vec4 ray_middle;  // w: near plane
    vec4 eye;         // xyz: the viewer, metres; w: 0 to 1, different for every sample of the image
    vec2 size;        // of this image, pixels
    float grid;       // pixels of this image per pixel of the final image, on one axis
    uint edge_grid;   // the same for an image of edge samples, else 0
};

layout(std430) readonly buffer Objects { ObjectRecord objects[]; };
layout(std140) uniform Views { ViewRecord views[MAX_VIEWS]; };
layout(push_constant, std430) uniform Draw {
    uint object; // index of its record
    uint view;
} draw;
#define OBJECT objects[draw.object]
#define VIEW views[draw.view]

#endif
