// Optional features of surfaces with more than one lobe. Each feature costs time only where it is enabled.
#ifndef LEADR_BASES
#define LEADR_BASES

// The number of lobes of the measured materials, or 0 if no surface has a measured base.
layout(constant_id = 59) const int FIT_LOBES = 0;
// Whether all surfaces have a measured base.
layout(constant_id = 83) const bool ALL_FITTED = false;
// The number of classes of facets of the relief, 1 to MOST_CLASSES. One class is one Gaussian of slopes.
layout(constant_id = 67) const int CLASSES = 1;
// Whether classes of facets hide each other. The classes of a smooth surface are those of its material.
layout(constant_id = 69) const bool CLASSES_HIDE = true;
// Whether the relief of triangles is projected along the axes. Each projection sees the classes from its own direction.
layout(constant_id = 58) const bool TRIPLANAR = false;
// Whether cones describe the occlusion by the surroundings.
layout(constant_id = 63) const bool CONES = false;
// Whether surfaces have a clear coat (leadr/visible/clear_coat.glsl).
layout(constant_id = 71) const bool COATED = false;
// Whether light passes through surfaces (leadr/visible/transmission.glsl).
layout(constant_id = 73) const bool TRANSMITS = false;

#endif
