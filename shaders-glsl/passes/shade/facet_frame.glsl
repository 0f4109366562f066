// Converts a surface to the frame of its own mean normal.
#ifndef LEADR_SHADE_FACET_FRAME
#define LEADR_SHADE_FACET_FRAME
#include "surface.glsl"
#include "leadr/slopes/grid.glsl"
#include "leadr/slopes/rotation.glsl"

// Used for the reference, where each sample hits one facet and the base is rough in the frame of this facet.
Surface in_facet_frame(Surface surface) {
    Frame macro = surface.frame;
    surface.frame = frame_about(from_frame(macro, normal_of_slope(surface.mean_slope)));
    mat3 rotation = mat3(to_frame(surface.frame, macro.x), to_frame(surface.frame, macro.y), to_frame(surface.frame, macro.z));
    surface.wo = rotation * surface.wo;
    surface.slope_covariance = rotate_slopes(rotation, surface.mean_slope, surface.slope_covariance).covariance;
    surface.mean_slope = vec2(0.0);
    return surface;
}

#endif
