// What the passes that draw one object at a time know of it: its record, and that of the view.
#ifndef LEADR_GEOMETRY_OBJECT
#define LEADR_GEOMETRY_OBJECT
#include "../constants.glsl"

struct ObjectRecord {
    vec4 color;         // of a plain one: linear albedo, Beckmann roughness alpha
    vec4 tangent_s;     // of a flat one: tangents by texture coordinate; w: 1, or -1 where they run clockwise seen from outside
    vec4 tangent_t;     // w: accessibility of a plain one
    vec2 shift;         // of a map that is shown without repeats: where its lattice lies, in repeats
    float height_scale; // eta of LEADR section 4.2
    float displacement; // the same for the geometry, which may be drawn smooth
    float relief;       // from the deepest pit to the highest bump, metres
    float viewer_above; // of a flat one: height of the viewer above its plane, metres
    float texel_repeat; // metres per repeat of its map, where a vertex stands at the centre of each of its texels
    float specular_f0;
    uint flags;         // FLAG_ bits
    uint number;        // in the scene, from 1
    uint fit;           // of its measured material, from 1, or 0
    uint dip;           // of a conductor, see unpack_dip
};

struct ViewRecord {
    mat4 clip_from_world;
    vec4 ray_x;       // of the image, as Camera::rays gives them; w: step from pixel to pixel in ndc, across
    vec4 ray_y;       // w: and down
    vec4 ray_middle;  // w: near plane
    vec4 eye;         // xyz: the viewer, metres; w: 0 to 1, another for every sample of the picture
    vec2 size;        // of this image, pixels
    float grid;       // pixels of this image along one of the picture
    uint edge_grid;   // the same where it consists of edge samples, else 0
};

layout(std430) readonly buffer Objects { ObjectRecord objects[]; };
layout(std140) uniform Views { ViewRecord views[MAX_VIEWS]; };
layout(push_constant, std430) uniform Draw {
    uint object; // index among the records
    uint view;
} draw;
#define OBJECT objects[draw.object]
#define VIEW views[draw.view]

#endif
