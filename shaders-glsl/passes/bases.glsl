// Optional features of a base beyond one lobe. Each costs time only where it is enabled.
#ifndef LEADR_BASES
#define LEADR_BASES

// Two roughnesses share a surface.
layout(constant_id = 49) const bool MIXED_ROUGHNESS = false;
// Lobes of measured materials; 0 if no surface has such a base.
layout(constant_id = 59) const int FIT_LOBES = 0;
// Whether all surfaces have a measured base.
layout(constant_id = 83) const bool ALL_FITTED = false;
// Occlusion of the surroundings by cones.
layout(constant_id = 63) const bool CONES = false;

#endif
