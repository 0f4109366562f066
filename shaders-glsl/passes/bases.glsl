// What surfaces may have beside a base of one lobe. It costs where it is there.
#ifndef LEADR_BASES
#define LEADR_BASES

// Two roughnesses share a surface.
layout(constant_id = 49) const bool MIXED_ROUGHNESS = false;
// Lobes of measured materials; none where no surface has such a base.
layout(constant_id = 59) const int FIT_LOBES = 0;
// Whether all surfaces have one.
layout(constant_id = 83) const bool ALL_FITTED = false;
// Cones in which surfaces see their surroundings.
layout(constant_id = 63) const bool CONES = false;

#endif
