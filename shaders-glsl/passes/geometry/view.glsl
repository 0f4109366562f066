// From where the geometry pass sees an object.
#ifndef LEADR_GEOMETRY_VIEW
#define LEADR_GEOMETRY_VIEW

layout(std140) uniform View {
    mat4 clip_from_world;
    vec4 camera_position; // xyz; w: pixels of this image along one of the picture
    vec4 texel_grid;      // x: metres per repeat of the map if a vertex stands at the centre of each of its texels, else 0; yz: size of this image, pixels
} view;

// Where in the image a point in clip space lies, in pixels times its w, and w. The viewport is GUARD_BAND times the image.
vec3 window_place(vec4 clip) {
    vec2 size = view.texel_grid.yz;
    return vec3(0.5 * (GUARD_BAND * clip.xy + clip.w) * size, clip.w);
}

#endif
