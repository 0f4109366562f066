// Push constants of the passes that draw one object at a time.
#ifndef LEADR_GEOMETRY_OBJECT
#define LEADR_GEOMETRY_OBJECT
#include "../constants.glsl"

layout(push_constant, std430) uniform Object {
    float height_scale; // eta of LEADR section 4.2
    float specular_f0;
    uint flags;         // FLAG_ bits; above them object_fit(); above that, when edge samples are drawn, their number across a pixel
    uint index;         // number of the object in the scene, from 1: object_index(); above it the dip of a conductor
    float relief;       // from the deepest pit to the highest bump, metres
#ifdef LEADR_OBJECT_SEEN
    float eye[3];       // the viewer, metres; of a flat object where its lattice lies, in repeats, and the viewer's height above its plane
    vec4 ray_x;         // of the image, as Camera::rays gives them; w: step from pixel to pixel in ndc, across
    vec4 ray_y;         // w: and down
    vec4 ray_middle;    // w: near plane
    vec4 tangent_s;     // of a flat object: tangents by texture coordinate; w: 1, or -1 where they run clockwise seen from outside; of others where the lattice lies
    vec4 tangent_t;     // w: accessibility of a plain one
    vec4 color;         // of a plain one: linear albedo, Beckmann roughness alpha
#else
    float shift[2];     // of a map that is shown without repeats: where its lattice lies, in repeats
#endif
} object;

uint object_index() {
    return object.index & ((1u << CONDUCTOR_DIP_SHIFT) - 1u);
}

// Number of its measured material, from 1, or 0.
uint object_fit() {
    return object.flags >> FLAGS_FIT_SHIFT & MAX_FITS;
}

#endif
