// From where the geometry pass sees an object.
#ifndef LEADR_GEOMETRY_VIEW
#define LEADR_GEOMETRY_VIEW

layout(std140) uniform View {
    mat4 clip_from_world;
    vec2 size;          // of this image, pixels
    float grid;         // pixels of this image along one of the picture
    float texel_repeat; // metres per repeat of the map if a vertex stands at the centre of each of its texels, else 0
    float draw;         // 0 to 1, another for every sample of the picture
} view;

#endif
