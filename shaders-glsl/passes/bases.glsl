// What bases surfaces may have. Each has mirrors of its own, which costs.
#ifndef LEADR_BASES
#define LEADR_BASES

// Two roughnesses share a surface.
layout(constant_id = 49) const bool MIXED_ROUGHNESS = false;
// Lobes of measured materials; none where no surface has such a base.
layout(constant_id = 59) const int FIT_LOBES = 0;

#endif
