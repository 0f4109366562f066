// The data for passes that draw one object at a time: the records of the object and of the view.
#ifndef LEADR_GEOMETRY_OBJECT
#define LEADR_GEOMETRY_OBJECT
#include "../constants.glsl"

struct ObjectRecord {
    vec4 color;         // plain objects: linear albedo, Beckmann roughness alpha
    vec4 tangent_s;     // flat objects: tangents by texture coordinate; w: 1, or -1 if clockwise seen from outside
    vec4 tangent_t;     // w: accessibility of a plain object
    vec2 shift;         // maps tiled by example: position of the lattice, in repeats
    float height_scale; // eta of LEADR section 4.2
    float displacement; // like height_scale, for the geometry, which may be smooth
    float relief;       // height of the relief from the deepest pit to the highest bump, in metres
    float viewer_above; // flat objects: height of the viewer above the plane, in metres
    float texel_repeat; // metres per repeat of the map, if there is one vertex per texel centre
    float specular_f0;
    uint flags;         // FLAG_ bits
    uint number;        // number of the object in the scene, from 1
    uint fit;           // number of its measured material, from 1, or 0
    uint edge_tint;     // F82 tint of a conductor (unpack_edge_tint)
    vec4 coat;          // clear coat: weight, Beckmann roughness, and 1 if the coat is smooth, 0 if it follows the relief
    uint medium;        // number of the medium behind the surface, from 1, or 0
    float scale_lod;   // level of detail of the height scale's map whose texels are as wide as those of the heights
    vec2 scale_offset; // texture coordinates of the height scale's map: scale_linear * texcoord + scale_offset
    vec4 scale_linear; // columns
    float detail_unit; // detail that displaces: unit of height_map per metre
    float detail_lod;  // level of detail of the detail whose texels are as wide as those of the heights
    uint spare[2];
    vec4 class_centers[4]; // centres of the classes: slopes by texture coordinate and height, in units of the map
    vec4 class_unit;       // units of the classes' moments about these centres; w: slope variance of the map in these units, xx + yy
    vec4 class_correlation[4]; // xyz: correlation of the openness of each class (leadr/masking/classes.glsl)
    vec4 class_sky_depth;   // optical depth of each class towards the sky (leadr/masking/class_sky.glsl)
};

struct ViewRecord {
    mat4 clip_from_world;
    vec4 ray_x;       // rays of the image (Camera::rays); w: horizontal step from pixel to pixel in normalised device coordinates
    vec4 ray_y;       // w: vertical step from pixel to pixel
    vec4 ray_middle;  // w: near plane
    vec4 eye;         // xyz: position of the viewer, in metres; w: a number from 0 to 1 that differs for every sample of the image
    vec2 size;        // size of this image in pixels
    float widening;   // factor on the footprints in the maps, 2^bias
    uint edge_grid;   // image of edge samples: samples along one side of a pixel; otherwise 0
};

layout(std430) readonly buffer Objects { ObjectRecord objects[]; };
layout(std140) uniform Views { ViewRecord views[MAX_VIEWS]; };
layout(push_constant, std430) uniform Draw {
    uint object; // index of the object's record
    uint view;
} draw;
#define OBJECT objects[draw.object]
#define VIEW views[draw.view]

#endif
